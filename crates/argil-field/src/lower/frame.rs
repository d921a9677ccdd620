//! The frame of a node, and its joint with what comes before it.

use super::error::LowerError;
use super::params::{align, keep};
use argil_abi::{self as abi, Instruction};
use argil_scene::{
    BlendProfile, Extent, Extents, Modifier, NodeDesc, NodeId, Operator, OperatorKind, Scene,
};
use glam::DAffine3;

/// The frame of a node: the map from the interpreter's point, the factor from its distances to the scene's, its
/// material, and the copies around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(super) own_from_point: DAffine3,
    pub(super) scale: f64,
    pub(super) material: u32,
    pub(super) copies: u64,
    /// The largest jump of the root's operand that contains it, once it is known.
    pub(super) jump: Option<f32>,
}

/// What surrounds the pieces of an open group.
pub(crate) struct EnclosingGroup {
    /// The frame of its contents.
    pub frame: Frame,
    /// The instructions that save the accumulator and combine it again. Their parameters are at 0.
    pub open: Instruction,
    pub close: Instruction,
    pub params: Vec<f32>,
}

impl EnclosingGroup {
    /// Creates it for a group in a frame.
    pub(crate) fn of(scene: &Scene, node: NodeId, within: Frame) -> Result<Self, LowerError> {
        let entry = scene.node(node).at_current_time();
        let names = || scene.materials().keys().zip(1..);
        let named = entry.material.as_ref();
        let found = named.and_then(|name| names().find(|(key, _)| *key == name));
        let mut frame = Frame {
            material: found.map_or(within.material, |(_, index)| index),
            ..within
        };
        for modifier in entry.modifiers.iter().rev() {
            map(scene, node, modifier, &mut frame)?;
        }
        let (flags, words) = combine_words(entry, within, false);
        let mut params = words.to_vec();
        align(&mut params);
        Ok(Self {
            frame,
            open: open_of(flags),
            close: Instruction {
                op: abi::OP_COMBINE,
                flags,
                ..Instruction::default()
            },
            params,
        })
    }
}

/// Returns k, 1/(4k) and the signs.
pub(super) fn joint(operator: &Operator, scale: f64) -> [f32; 5] {
    let k = (f64::from(operator.blend) * scale) as f32;
    let quarter = if k > 0.0 { 0.25 / k } else { 0.0 };
    let [a, b, r] = match operator.kind {
        OperatorKind::Subtract => [-1.0, 1.0, -1.0],
        OperatorKind::Intersect => [-1.0, -1.0, -1.0],
        _ => [1.0, 1.0, 1.0],
    };
    [k, quarter, a, b, r]
}

/// Returns the flags and words of a joint with a saved value.
pub(super) fn combine_words(entry: &NodeDesc, frame: Frame, swapped: bool) -> (u32, [f32; 6]) {
    let mode = match (entry.operator.kind, entry.operator.profile) {
        (OperatorKind::Paint, _) => abi::COMBINE_PAINT,
        (OperatorKind::Morph, _) => abi::COMBINE_MORPH,
        (_, BlendProfile::Chamfer) => abi::COMBINE_CHAMFER,
        (_, BlendProfile::Smooth) => abi::COMBINE_SMOOTH,
    };
    let [k, quarter, a, b, r] = joint(&entry.operator, frame.scale);
    let flags = mode | keep(entry) | if swapped { abi::FLAG_SWAPPED } else { 0 };
    (flags, [k, quarter, a, b, r, entry.operator.morph_amount])
}

/// Returns the instruction that saves the value before an operand, given the flags of its joint.
pub(super) fn open_of(joint_flags: u32) -> Instruction {
    let is_paint = joint_flags & (abi::COMBINE_MASK | abi::FLAG_SWAPPED) == abi::COMBINE_PAINT;
    Instruction {
        op: abi::OP_PUSH_VALUE,
        flags: if is_paint { abi::FLAG_PAINT } else { 0 },
        ..Instruction::default()
    }
}

/// Returns a node's extent in the scene's space, if all groups around it are open.
pub(crate) fn extent_in_world(scene: &Scene, extents: &mut Extents<'_>, node: NodeId) -> Extent {
    let mut extent = extents.node_bounds(node);
    let mut at = scene.node(node).parent();
    while let Some(group) = at {
        extent = extent.under(&scene.node(group).at_current_time().modifiers);
        at = scene.node(group).parent();
    }
    extent
}

/// Applies a translate, rotate, scale or stretch.
pub(super) fn map(
    scene: &Scene,
    node: NodeId,
    modifier: &Modifier,
    frame: &mut Frame,
) -> Result<(), LowerError> {
    if let Some(map) = modifier.affine() {
        frame.own_from_point = map * frame.own_from_point;
        frame.scale *= f64::from(modifier.scale());
        if !(1e-6..=1e6).contains(&frame.scale) {
            return Err(LowerError::Scale {
                path: scene.path(node),
                scale: frame.scale,
            });
        }
    }
    Ok(())
}

impl Frame {
    pub(crate) const OF_WORLD: Self = Self {
        own_from_point: DAffine3::IDENTITY,
        scale: 1.0,
        material: 0,
        copies: 1,
        jump: None,
    };
}
