//! Imports scenes in the tree format of "Lipschitz Pruning: Hierarchical Simplification of Primitive-Based SDFs"
//! (Barbier et al., Eurographics 2025).
//!
//! *Theory.* In that format, a scene is a binary tree of operators over primitives. The left spine of the tree is a
//! list: `((a ∪ b) ∪ c) − d` becomes one group of four brushes. Only a right child that is an operator, or a
//! transformed operator, needs a group of its own.
//!
//! *Practice.* Trees may be thousands of levels deep, so both passes keep their stack on the heap. Unlike in the
//! authors' renderer, a blend radius below 1e-6 makes a hard joint.

use crate::{
    Brush, CameraPose, Group, Material, Modifier, NodeDesc, NodeId, OperatorKind, Scene, Shape,
    ValidationError,
};
use glam::{DMat3, DQuat, DVec3, Vec3};
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use struson::reader::{JsonReader, JsonStreamReader, ReaderError, ReaderSettings};

/// The reason why a tree cannot be imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is not JSON, or not an object of objects.
    #[error("{path}:{line}:{column}: not a tree file: {reason}")]
    Syntax {
        /// Path of the file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The column, from 1.
        column: u64,
        /// What is wrong there.
        reason: String,
    },
    /// A node of the tree cannot be used.
    #[error("{path}:{line}: {node}: {fault}")]
    Node {
        /// Path of the file.
        path: PathBuf,
        /// The line on which the node begins, from 1.
        line: u64,
        /// The path to the node: L is a left child, and R a right one.
        node: String,
        /// What is wrong in it.
        fault: ValidationError,
    },
}

/// A node of the file.
struct TreeNode {
    line: u64,
    parent: Option<(usize, char)>,
    fields: Map<String, Value>,
    left: Option<usize>,
    right: Option<usize>,
}

impl Scene {
    /// Imports a scene in the tree format.
    ///
    /// # Errors
    /// If the file cannot be read, is not a tree of this format, or uses an operation that scenes do not have.
    pub fn import_tree(path: impl AsRef<Path>) -> Result<Self, ImportError> {
        Self::import_tree_file(path.as_ref())
    }

    fn import_tree_file(path: &Path) -> Result<Self, ImportError> {
        let io = |source| ImportError::Io {
            path: path.into(),
            source,
        };
        let file = std::fs::File::open(path).map_err(io)?;
        let tree = read_tree(file).map_err(|error| match error {
            ReaderError::IoError { error, .. } => io(error),
            other => syntax_error(path, &other),
        })?;
        to_scene(&tree).map_err(|(index, fault)| ImportError::Node {
            path: path.into(),
            line: tree[index].line,
            node: way_to(&tree, index),
            fault,
        })
    }
}

/// Returns an error with line and column of a file that is no tree.
fn syntax_error(path: &Path, error: &ReaderError) -> ImportError {
    let (location, reason) = match error {
        ReaderError::SyntaxError(error) => (Some(&error.location), "invalid JSON".into()),
        ReaderError::UnexpectedValueType {
            expected,
            actual,
            location,
        } => {
            let [expected, actual] = [expected, actual].map(|kind| kind.to_string().to_lowercase());
            (
                Some(location),
                format!("expected {expected}, found {actual}"),
            )
        }
        ReaderError::UnexpectedStructure { location, .. } => {
            (Some(location), "unexpected end of an object".into())
        }
        ReaderError::MaxNestingDepthExceeded { location, .. } => {
            (Some(location), "objects are nested too deeply".into())
        }
        ReaderError::UnsupportedNumberValue { number, location } => (
            Some(location),
            format!("the number {number} is out of range"),
        ),
        other => (None, other.to_string()),
    };
    let place = location.and_then(|location| location.line_pos.as_ref());
    ImportError::Syntax {
        path: path.into(),
        line: place.map_or(1, |position| position.line + 1),
        column: place.map_or(1, |position| position.column + 1),
        reason,
    }
}

/// Reads all nodes, each before its children. The first is the root.
fn read_tree(source: impl std::io::Read) -> Result<Vec<TreeNode>, ReaderError> {
    let settings = ReaderSettings {
        max_nesting_depth: Some(1_000_000),
        track_path: false,
        ..ReaderSettings::default()
    };
    let mut reader = JsonStreamReader::new_custom(source, settings);
    let mut tree: Vec<TreeNode> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut parent = None;
    loop {
        // Begin a node.
        reader.begin_object()?;
        let line = reader
            .current_position(false)
            .line_pos
            .map_or(0, |p| p.line)
            + 1;
        open.push(tree.len());
        tree.push(TreeNode {
            line,
            parent,
            fields: Map::new(),
            left: None,
            right: None,
        });

        // Continue with the next child, and close what ends.
        parent = None;
        while let Some(&at) = open.last() {
            if !reader.has_next()? {
                reader.end_object()?;
                open.pop();
                continue;
            }
            let key = reader.next_name_owned()?;
            if key == "leftChild" || key == "rightChild" {
                let child = Some(tree.len());
                let (slot, side) = if key == "leftChild" {
                    (&mut tree[at].left, 'L')
                } else {
                    (&mut tree[at].right, 'R')
                };
                *slot = child;
                parent = Some((at, side));
                break;
            }
            let mut text = Vec::new();
            let mut writer =
                struson::writer::JsonStreamWriter::new(crate::file::read::Limited(&mut text));
            match reader.transfer_to(&mut writer) {
                Ok(()) => {}
                Err(struson::reader::TransferError::ReaderError(error)) => return Err(error),
                Err(struson::reader::TransferError::WriterError(error)) => {
                    return Err(ReaderError::IoError {
                        error,
                        location: reader.current_position(false),
                    });
                }
            }
            let _ = struson::writer::JsonWriter::finish_document(writer);
            // A field too deep for serde is of no use in a node.
            let value = serde_json::from_slice(&text).unwrap_or(Value::Null);
            tree[at].fields.insert(key, value);
        }
        if open.is_empty() {
            reader.consume_trailing_whitespace()?;
            return Ok(tree);
        }
    }
}

fn way_to(tree: &[TreeNode], index: usize) -> String {
    let mut way = Vec::new();
    let mut at = index;
    while let Some((parent, side)) = tree[at].parent {
        way.push(side);
        at = parent;
    }
    way.push('/');
    let text: String = way.iter().rev().collect();
    if text.len() <= 40 {
        text
    } else {
        format!(
            "{}…{} ({} levels deep)",
            &text[..20],
            &text[text.len() - 16..],
            text.len()
        )
    }
}

type Failure = (usize, ValidationError);

fn to_scene(tree: &[TreeNode]) -> Result<Scene, Failure> {
    let mut scene = Scene::new();
    let corner = |key: &str| floats::<3>(&tree[0].fields, key).map_err(|f| (0, f));
    if tree[0].fields.contains_key("aabb_min") {
        scene.view.bounds = Some([corner("aabb_min")?, corner("aabb_max")?]);
        scene.view.check().map_err(|f| (0, f))?;
    }
    scene.view.camera = CameraPose::Orbit([30.0, 20.0, 2.5]);
    let mut colors: HashMap<[u32; 3], String> = HashMap::new();

    // Each task appends one tree node to a group.
    let mut tasks: Vec<(usize, NodeId, NodeDesc)> = vec![(0, Scene::ROOT, Group::new().into())];
    while let Some((index, parent, operand)) = tasks.pop() {
        let node = &tree[index];
        let failed = |fault: ValidationError| (index, fault);
        let modifiers = transform(&node.fields).map_err(failed)?;
        match text(&node.fields, "nodeType").map_err(failed)? {
            "primitive" => {
                let (shape, mut shape_modifiers) = primitive(&node.fields).map_err(failed)?;
                let mut entry: NodeDesc = Brush::new(shape).into();
                shape_modifiers.extend(modifiers);
                (entry.operator, entry.modifiers) = (operand.operator, shape_modifiers);
                entry.material =
                    Some(material(&mut scene, &mut colors, &node.fields).map_err(failed)?);
                entry.check().map_err(failed)?;
                scene.append(parent, entry);
            }
            "binaryOperator" => {
                let child = |child: Option<usize>, key: &str| {
                    child.ok_or(failed(ValidationError::new(key, "is missing")))
                };
                let (left, right) = (
                    child(node.left, "leftChild")?,
                    child(node.right, "rightChild")?,
                );
                // The spine continues in the same list if the list is empty and the node is not transformed.
                let first = scene.node(parent).children().is_empty();
                let list = if first && modifiers.is_empty() {
                    parent
                } else {
                    let group = NodeDesc {
                        modifiers,
                        ..operand
                    };
                    group.check().map_err(failed)?;
                    scene.append(parent, group)
                };
                let mut right_operand: NodeDesc = Group::new().into();
                right_operand.operator.kind =
                    match text(&node.fields, "blendMode").map_err(failed)? {
                        "union" => OperatorKind::Union,
                        "sub" => OperatorKind::Subtract,
                        "inter" => OperatorKind::Intersect,
                        other => {
                            return Err(failed(ValidationError::new(
                                "blendMode",
                                format!("\"{other}\" is not union, sub or inter"),
                            )));
                        }
                    };
                let blend = number(&node.fields, "blendRadius").map_err(failed)?;
                right_operand.operator.blend = if blend.abs() < 1e-6 { 0.0 } else { blend };
                right_operand.check().map_err(failed)?;
                tasks.push((right, list, right_operand));
                tasks.push((left, list, Group::new().into()));
            }
            other => {
                let reason = format!("\"{other}\" is neither primitive nor binaryOperator");
                return Err(failed(ValidationError::new("nodeType", reason)));
            }
        }
    }
    Ok(scene)
}

fn primitive(fields: &Map<String, Value>) -> Result<(Shape, Vec<Modifier>), ValidationError> {
    let shape = match text(fields, "primitiveType")? {
        "sphere" => Shape::sphere(number(fields, "radius")?),
        "box" => {
            let half_size = floats::<3>(fields, "sides")?.map(|s| 0.5 * s);
            // The bevel is a full length like the sides: a bevel as long as a side makes it round.
            let corner_radii = floats::<4>(fields, "bevel")?.map(|b| 0.5 * b);
            let rounding = [number(fields, "round_x")?, number(fields, "round_y")?];
            if corner_radii == [0.0; 4] && rounding == [0.0; 2] {
                Shape::cuboid(half_size)
            } else {
                Shape::ExtrudedRoundedBox {
                    half_size,
                    corner_radii,
                    rounding,
                }
            }
        }
        "cylinder" => Shape::cylinder(number(fields, "radius")?, 0.5 * number(fields, "height")?),
        "cone" => {
            let (radius, height) = (number(fields, "radius")?, number(fields, "height")?);
            let raise = Modifier::Translate {
                by: [0.0, 0.5 * height, 0.0],
            };
            return Ok((Shape::Cone { radius, height }, vec![raise]));
        }
        other => {
            return Err(ValidationError::new(
                "primitiveType",
                format!("\"{other}\" is not sphere, box, cylinder or cone"),
            ));
        }
    };
    Ok((shape, Vec::new()))
}

/// Returns the modifiers that place a node, from the map from its parent's space into its own.
fn transform(fields: &Map<String, Value>) -> Result<Vec<Modifier>, ValidationError> {
    if !fields.contains_key("matrix") {
        return Ok(Vec::new());
    }
    let m = floats::<12>(fields, "matrix")?.map(f64::from);
    let rows = DMat3::from_cols(
        DVec3::new(m[0], m[1], m[2]),
        DVec3::new(m[4], m[5], m[6]),
        DVec3::new(m[8], m[9], m[10]),
    );
    let own_from_parent = rows.transpose();
    let offset = DVec3::new(m[3], m[7], m[11]);
    let scale = own_from_parent.determinant().cbrt();
    let turned = own_from_parent * (1.0 / scale);
    let is_rotation = (turned * turned.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-3);
    if !(scale.is_finite() && scale > 1e-6 && is_rotation) {
        let reason =
            "does more than rotate, move and scale alike along all axes: distances would be wrong";
        return Err(ValidationError::new("matrix", reason));
    }
    let mut modifiers = Vec::new();
    if (scale - 1.0).abs() > 1e-6 {
        modifiers.push(Modifier::Scale {
            by: (1.0 / scale) as f32,
        });
    }
    let parent_from_own = DQuat::from_mat3(&turned.transpose()).normalize();
    let (axis, angle) = parent_from_own.to_axis_angle();
    if angle.abs() > 1e-7 {
        modifiers.push(Modifier::Rotate {
            axis: axis.as_vec3().to_array(),
            degrees: angle.to_degrees() as f32,
        });
    }
    let by = (parent_from_own * (-offset / scale)).as_vec3();
    if by != Vec3::ZERO {
        modifiers.push(Modifier::Translate { by: by.to_array() });
    }
    Ok(modifiers)
}

/// Returns the name of the material for a node's color.
fn material(
    scene: &mut Scene,
    names: &mut HashMap<[u32; 3], String>,
    fields: &Map<String, Value>,
) -> Result<String, ValidationError> {
    // The file's colors are sRGB, and scenes use linear colors.
    let color = floats::<3>(fields, "color")?.map(|c| c.clamp(0.0, 1.0).powf(2.2));
    let next = format!("color_{}", names.len() + 1);
    let name = names.entry(color.map(f32::to_bits)).or_insert(next).clone();
    if !scene.materials.contains_key(&name) {
        scene.set_material(name.clone(), Material::colored(color))?;
    }
    Ok(name)
}

fn get<'a>(fields: &'a Map<String, Value>, key: &str) -> Result<&'a Value, ValidationError> {
    fields
        .get(key)
        .ok_or_else(|| ValidationError::new(key, "is missing"))
}

fn text<'a>(fields: &'a Map<String, Value>, key: &str) -> Result<&'a str, ValidationError> {
    get(fields, key)?
        .as_str()
        .ok_or_else(|| ValidationError::new(key, "is not a string"))
}

fn number(fields: &Map<String, Value>, key: &str) -> Result<f32, ValidationError> {
    get(fields, key)?
        .as_f64()
        .map(|v| v as f32)
        .ok_or_else(|| ValidationError::new(key, "is not a number"))
}

fn floats<const N: usize>(
    fields: &Map<String, Value>,
    key: &str,
) -> Result<[f32; N], ValidationError> {
    let values: Option<Vec<f32>> = get(fields, key)?
        .as_array()
        .and_then(|a| a.iter().map(|v| v.as_f64().map(|v| v as f32)).collect());
    values
        .and_then(|v| v.try_into().ok())
        .ok_or_else(|| ValidationError::new(key, format!("is not a list of {N} numbers")))
}
