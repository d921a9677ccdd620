//! Macros that declare a struct or a constant in both languages.

use crate::layout::StructLayout;

/// The WGSL name of a Rust type that structs may contain.
pub(crate) trait Wgsl {
    const NAME: &'static str;
}
impl Wgsl for u32 {
    const NAME: &'static str = "u32";
}
impl Wgsl for i32 {
    const NAME: &'static str = "i32";
}
impl Wgsl for f32 {
    const NAME: &'static str = "f32";
}
/// Followed by one more word, so that Rust's struct has no gap where WGSL's has none. A test asks naga.
impl Wgsl for [f32; 3] {
    const NAME: &'static str = "vec3<f32>";
}
impl Wgsl for [f32; 4] {
    const NAME: &'static str = "vec4<f32>";
}

impl Wgsl for [[f32; 4]; crate::LAMP_ROWS] {
    const NAME: &'static str = "array<vec4<f32>, 32>";
}

/// Declares `u32` constants, with their WGSL lines in a slice of the given name.
macro_rules! constants {
    ($all:ident: $($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: u32 = $value;)*
        pub(crate) const $all: &[(&str, u32)] = &[$((stringify!($name), $name)),*];
    };
}

/// A number type that WGSL constants can have.
pub(crate) trait Number {
    /// Returns the WGSL line of a constant.
    fn line(&self, name: &str) -> String;
}

impl Number for u32 {
    fn line(&self, name: &str) -> String {
        format!("const {name}: u32 = {self}u;\n")
    }
}

impl Number for f32 {
    fn line(&self, name: &str) -> String {
        format!("const {name}: f32 = {self:?};\n")
    }
}

impl Number for [f32; 3] {
    fn line(&self, name: &str) -> String {
        let [x, y, z] = self;
        format!("const {name} = vec3<f32>({x:?}, {y:?}, {z:?});\n")
    }
}

/// Declares constants of any such type, with a function of the given name that returns their WGSL lines.
macro_rules! numbers {
    ($all:ident: $($(#[$doc:meta])* $name:ident: $type:ty = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $type = $value;)*
        pub(crate) const $all: &[(&str, &dyn $crate::declare::Number)] = &[$((stringify!($name), &$name)),*];
    };
}

/// Declares a `#[repr(C)]` Pod struct with its [`StructLayout`] and its WGSL text.
macro_rules! shared_struct {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_doc])* pub $field: $type,)* }
        impl $name {
            /// Size and field offsets, which a test compares with naga's.
            pub const LAYOUT: $crate::layout::StructLayout = $crate::layout::StructLayout {
                name: stringify!($name),
                size: size_of::<$name>(),
                fields: &[$((stringify!($field), std::mem::offset_of!($name, $field))),*],
            };
            pub(crate) const FIELD_TYPES: &[&str] = &[$(<$type as $crate::declare::Wgsl>::NAME),*];
        }
        impl $crate::declare::Wgsl for $name {
            const NAME: &'static str = stringify!($name);
        }
    };
}

pub(crate) use {constants, numbers, shared_struct};

/// Returns the WGSL text of constants.
pub(crate) fn constants_text(all: &[(&str, u32)]) -> String {
    all.iter()
        .map(|(name, value)| format!("const {name}: u32 = {value}u;\n"))
        .collect()
}

/// Returns the WGSL text of a struct.
pub(crate) fn struct_text(layout: &StructLayout, types: &[&str]) -> String {
    let fields: String = layout
        .fields
        .iter()
        .zip(types)
        .map(|((name, _), kind)| format!("    {name}: {kind},\n"))
        .collect();
    format!("struct {} {{\n{fields}}}\n", layout.name)
}
