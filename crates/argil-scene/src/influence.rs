//! Computes where a brush or group can matter.
//!
//! *Theory.* A change matters where the scene's distance, clamped to ±band, differs. A smooth union of radius k
//! shows an operand's change only where the operand is below the other operand plus k. So the change lies in the
//! operand's box, grown by band + k. Later operands carry changes farther: if a value reaches the final band only
//! through a later blend of radius k, it was at most k higher before. These radii add up over the operands that are
//! near, but not forever. A blend that lowers a value by δ passes at most (k − δ) / 2k of a change. After a total
//! fall of 7 k, less than 2⁻²⁴ of it is left, which `f32` cannot show.
//!
//! *Practice.* [`influence`] walks down from the root to the node and tracks the largest distance of interest at
//! each level. Then it maps the node's grown box up through the modifiers of its groups.

use crate::group_summary::{GroupSummary, SUMMARY_THRESHOLD};
use crate::modified_region::region_after;
use crate::{BlendProfile, Extent, Extents, Modifier, NodeId, Operator, OperatorKind, Scene};
use argil_math::Aabb;

/// Decrease of a distance after which `f32` cannot represent the rest of a change, in units of the largest blend
/// radius. The second value is for scenes with chamfers, which pass 1/√2 of a change per joint.
const SMOOTH_FALLS: f32 = 7.0;
const CHAMFER_FALLS: f32 = 48.0;

/// Returns how far a distance can decrease through any number of joints before `f32` cannot represent the rest of a
/// change. `blend` is the largest blend radius, and `interest` is the largest distance of interest.
pub fn max_blend_propagation(blend: f32, has_chamfers: bool, interest: f32) -> f32 {
    if has_chamfers {
        CHAMFER_FALLS * (blend + 0.6 * interest)
    } else {
        SMOOTH_FALLS * blend
    }
}

/// Returns a box outside which the scene's distance, clamped to ±`band`, does not depend on a node.
pub(crate) fn influence(scene: &Scene, extents: &mut Extents<'_>, node: NodeId, band: f32) -> Aabb {
    // The first box counts every later blend. The next ones count only operands near the previous box.
    let mut bounds = Aabb::ALL;
    for _ in 0..4 {
        let tighter = grown_box(scene, extents, node, band, bounds);
        if tighter == bounds {
            break;
        }
        bounds = tighter;
    }
    bounds
}

fn grown_box(
    scene: &Scene,
    extents: &mut Extents<'_>,
    node: NodeId,
    band: f32,
    near: Aabb,
) -> Aabb {
    let mut chain = vec![node];
    while let Some(parent) = scene.node(chain[chain.len() - 1]).parent {
        chain.push(parent);
    }
    chain.reverse();
    if chain[0] != Scene::ROOT
        || chain
            .iter()
            .any(|&id| !scene.node(id).at_current_time().visible)
    {
        return Aabb::EMPTY;
    }

    // Down: the distance of interest at each level, and the modifiers on the way.
    let mut interest = band;
    let mut passed: Vec<(&Modifier, f32, Extent)> = Vec::new();
    let mut region = Aabb::EMPTY;
    // Boxes of siblings can be compared with `near` only while their frame is the world's.
    let mut in_world = true;
    for pair in chain.windows(2) {
        let (parent, child) = (pair[0], pair[1]);
        let siblings = &scene.node(parent).children;
        let entry = scene.node(child).at_current_time();

        let (falls, morphed) = match scene.summaries.get(&parent) {
            Some(summary) if siblings.len() > SUMMARY_THRESHOLD => summary_falls(summary, interest),
            _ => {
                let index = siblings
                    .iter()
                    .rposition(|&c| c == child)
                    .expect("a node is among its parent's children");
                let near = in_world.then_some(near);
                later_falls(scene, extents, &siblings[index + 1..], interest, near)
            }
        };
        interest += falls + blend_influence_radius(&entry.operator, interest);
        if morphed
            || matches!(
                entry.operator.kind,
                OperatorKind::Intersect | OperatorKind::Morph
            )
        {
            // These act on all the space that their list fills. Ramps divide what is there.
            let visible = |s: &&NodeId| scene.node(**s).at_current_time().visible;
            let everything = siblings.iter().filter(visible);
            interest *= everything
                .clone()
                .map(|&s| scene.ramp_stretch(s))
                .product::<f32>();
            region = everything
                .map(|&s| extents.node_bounds(s))
                .fold(Aabb::EMPTY, |b, e| {
                    b.union(e.aabb.grown(e.lipschitz_inverse * interest))
                });
            break;
        }
        if child == node {
            let outer = extents.node_bounds(child);
            region = outer.aabb.grown(outer.lipschitz_inverse * interest);
        } else if !entry.modifiers.is_empty() {
            // A group is measured only if its modifiers need its box, because it may be large.
            let asks = entry.modifiers.iter().any(|m| m.affine().is_none());
            let stages = if asks {
                extents.modifier_stages(child)
            } else {
                vec![Extent::EMPTY; entry.modifiers.len()]
            };
            for (modifier, content) in entry.modifiers.iter().zip(&stages).rev() {
                passed.push((modifier, interest, *content));
                interest = interest_inside(modifier, interest, content);
            }
            in_world = false;
        }
    }

    // Up: through the modifiers of the groups, innermost first.
    for (modifier, interest, content) in passed.into_iter().rev() {
        region = region_after(modifier, region, &content);
        // Beyond the ends of an extrusion, as beyond a clamp's box, distances depend on what is within.
        if modifier.clamp(&content).is_some() || matches!(modifier, Modifier::Extrude { .. }) {
            region = region.grown(interest);
        }
    }
    region
}

/// Returns how much the operator's own joint extends the region that a change can affect. `interest` is the largest
/// distance of interest.
pub fn blend_influence_radius(operator: &Operator, interest: f32) -> f32 {
    match operator.profile {
        BlendProfile::Smooth => operator.blend,
        // (a + b − k)/√2 < min(a, b) if |a − b| < k + (2 − √2)·|min|, and |min| is at most the distance of
        // interest.
        BlendProfile::Chamfer if operator.blend > 0.0 => operator.blend + 0.6 * interest,
        BlendProfile::Chamfer => 0.0,
    }
}

/// Returns what `later_falls` returns, for all operands of a large group, wherever they are.
fn summary_falls(summary: &GroupSummary, interest: f32) -> (f32, bool) {
    let fall = max_blend_propagation(summary.max_blend(), summary.has_chamfers(), interest);
    (fall, summary.has_morphs())
}

/// Returns how far values of interest can fall through the later operands, and whether one of them is a morph.
fn later_falls(
    scene: &Scene,
    extents: &mut Extents<'_>,
    later: &[NodeId],
    interest: f32,
    near: Option<Aabb>,
) -> (f32, bool) {
    let (mut sum, mut greatest, mut chamfered, mut morphed) = (0.0f32, 0.0f32, false, false);
    for &id in later.iter().rev() {
        let entry = scene.node(id).at_current_time();
        if !entry.visible {
            continue;
        }
        let operator = &entry.operator;
        morphed |= operator.kind == OperatorKind::Morph;
        let fall = blend_influence_radius(operator, interest);
        if fall == 0.0 || operator.kind == OperatorKind::Paint {
            continue;
        }
        let outer = extents.node_bounds(id);
        let reach = outer
            .aabb
            .grown(outer.lipschitz_inverse * (interest + sum + fall));
        // An intersection acts most where its operand is not.
        let apart = operator.kind != OperatorKind::Intersect
            && near.is_some_and(|near| near.intersection(reach).is_empty());
        if apart {
            continue;
        }
        sum += fall;
        greatest = greatest.max(fall);
        chamfered |= operator.profile == BlendProfile::Chamfer;
    }
    (
        sum.min(
            greatest
                * if chamfered {
                    CHAMFER_FALLS
                } else {
                    SMOOTH_FALLS
                },
        ),
        morphed,
    )
}

/// Returns the distance of interest before a modifier, given the one after it.
fn interest_inside(modifier: &Modifier, interest: f32, content: &Extent) -> f32 {
    match *modifier {
        Modifier::Scale { .. } | Modifier::Stretch { .. } | Modifier::ScaleDistance { .. } => {
            interest / modifier.scale()
        }
        Modifier::Instances { ref poses } => interest / poses.scales()[0],
        Modifier::Round { radius } => interest + radius.abs(),
        Modifier::Shell { half_thickness } => interest + half_thickness,
        Modifier::Displace { amplitude, .. } => {
            interest * modifier.stretch(content) + 2.0 * amplitude
        }
        _ => interest * modifier.stretch(content),
    }
}
