//! Tests that no branch of a shader depends on uniforms alone: Mesa's software device would compile it again for each dispatch.

use argil_field::Program;
use naga::{AddressSpace, Block, Expression, Function, Handle, Module, Statement};

/// What an expression depends on.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
enum Source {
    Constants,
    Uniforms,
    Threads,
}

/// Returns what an expression depends on. An index that is computed counts as a thread's.
fn source(module: &Module, function: &Function, expression: Handle<Expression>) -> Source {
    let of = |part: Handle<Expression>| source(module, function, part);
    let most = |parts: &[Handle<Expression>]| {
        let all = parts.iter().map(|&part| of(part));
        all.fold(Source::Constants, |a, b| if a < b { b } else { a })
    };
    match &function.expressions[expression] {
        Expression::Literal(_)
        | Expression::Constant(_)
        | Expression::Override(_)
        | Expression::ZeroValue(_) => Source::Constants,
        Expression::GlobalVariable(variable) => match module.global_variables[*variable].space {
            AddressSpace::Uniform => Source::Uniforms,
            _ => Source::Threads,
        },
        Expression::Load { pointer: part }
        | Expression::AccessIndex { base: part, .. }
        | Expression::Splat { value: part, .. }
        | Expression::Swizzle { vector: part, .. }
        | Expression::Unary { expr: part, .. }
        | Expression::As { expr: part, .. }
        | Expression::Relational { argument: part, .. } => of(*part),
        Expression::Compose { components, .. } => most(components),
        Expression::Binary { left, right, .. } => most(&[*left, *right]),
        Expression::Select {
            condition,
            accept,
            reject,
        } => most(&[*condition, *accept, *reject]),
        Expression::Math {
            arg,
            arg1,
            arg2,
            arg3,
            ..
        } => {
            let others = [arg1, arg2, arg3].into_iter().flatten().copied();
            most(&[*arg].into_iter().chain(others).collect::<Vec<_>>())
        }
        _ => Source::Threads,
    }
}

/// Counts the branches of a block that depend on uniforms alone.
fn uniform_branches(module: &Module, function: &Function, block: &Block) -> usize {
    let inner = |block: &Block| uniform_branches(module, function, block);
    let is_uniform = |expression: &Handle<Expression>| {
        usize::from(source(module, function, *expression) == Source::Uniforms)
    };
    let of = |statement: &Statement| match statement {
        Statement::Block(block) => inner(block),
        Statement::If {
            condition,
            accept,
            reject,
        } => is_uniform(condition) + inner(accept) + inner(reject),
        Statement::Switch { selector, cases } => {
            is_uniform(selector) + cases.iter().map(|case| inner(&case.body)).sum::<usize>()
        }
        Statement::Loop {
            body,
            continuing,
            break_if,
        } => break_if.iter().map(is_uniform).sum::<usize>() + inner(body) + inner(continuing),
        _ => 0,
    };
    block.iter().map(of).sum()
}

/// Returns the functions of a source that have such branches.
fn branching_functions(source: &str) -> Vec<String> {
    let module = naga::front::wgsl::parse_str(source).expect("valid WGSL");
    let entry_points = module
        .entry_points
        .iter()
        .map(|entry_point| &entry_point.function);
    let functions = module.functions.iter().map(|(_, function)| function);
    let all = functions.chain(entry_points);
    let with_branches =
        all.filter(|function| uniform_branches(&module, function, &function.body) > 0);
    with_branches
        .map(|function| function.name.clone().unwrap_or_default())
        .collect()
}

#[test]
fn no_branch_depends_on_uniforms_alone() {
    let scene = argil_conformance::universal();
    let program = Program::lower(&scene).expect("a program");
    let modules = argil_gpu::hardware_modules(&program);
    assert!(modules.len() > 30);
    let all = modules.iter().flat_map(|module| {
        let functions = branching_functions(&module.source).into_iter();
        functions.map(|function| format!("{}: {function}", module.name))
    });
    let all: Vec<String> = all.collect();
    assert_eq!(all, [""; 0], "use `per_thread`");
}

#[test]
fn branches_on_uniforms_are_found() {
    let common = "struct Frame { mode: u32, sizes: vec3<f32> }
        @group(0) @binding(0) var<uniform> frame: Frame;
        @group(0) @binding(1) var<storage, read> words: array<u32>;";
    for (body, count) in [
        ("if frame.mode == 1u { return 1u; }", 1),
        (
            "switch frame.mode { case 1u: { return 1u; } default: {} }",
            1,
        ),
        ("if any(frame.sizes.xy > vec2(1.0)) { return 1u; }", 1),
        (
            "for (var i = 0u; i < x; i++) { if frame.mode != 0u { return i; } }",
            1,
        ),
        ("if frame.mode != 0u && x == 1u { return 1u; }", 1),
        ("if x == 1u && frame.mode != 0u { return 1u; }", 0),
        ("if words[x] == frame.mode { return 1u; }", 0),
        (
            "let d = select(0u, x, frame.mode == 1u); if d > 1u { return d; }",
            0,
        ),
    ] {
        let source = format!("{common} fn f(x: u32) -> u32 {{ {body} return 0u; }}");
        assert_eq!(branching_functions(&source).len(), count, "{body}");
    }
}
