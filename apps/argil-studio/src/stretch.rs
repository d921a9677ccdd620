//! Scales a shape along one of its own axes, if it has a parameter for that.

use argil::scene::Shape;

/// Returns the shape scaled by `factor` along an axis (0, 1 or 2). `None` if it has no parameter for that axis
/// alone.
pub(crate) fn stretched(shape: &Shape, axis: usize, factor: f32) -> Option<Shape> {
    let mut changed = shape.clone();
    let length = match &mut changed {
        Shape::Sphere { radius } => {
            let mut radii = [*radius; 3];
            radii[axis] *= factor;
            return Some(Shape::Ellipsoid { radii });
        }
        Shape::Ellipsoid { radii } | Shape::Superellipsoid { radii, .. } => &mut radii[axis],
        Shape::Box { half_size, .. }
        | Shape::BoxFrame { half_size, .. }
        | Shape::Gyroid { half_size, .. }
        | Shape::SchwarzP { half_size, .. } => &mut half_size[axis],
        Shape::Cylinder { half_height, .. } | Shape::CappedCone { half_height, .. }
            if axis == 1 =>
        {
            half_height
        }
        Shape::Cone { height, .. } | Shape::Pyramid { height, .. } if axis == 1 => height,
        Shape::HexPrism { half_depth, .. }
        | Shape::TriPrism { half_depth, .. }
        | Shape::Text { half_depth, .. }
            if axis == 2 =>
        {
            half_depth
        }
        Shape::Link { half_length, .. } if axis == 1 => half_length,
        Shape::Rhombus {
            half_length_x,
            half_length_z,
            half_height,
            ..
        } => [half_length_x, half_height, half_length_z]
            .into_iter()
            .nth(axis)?,
        _ => return None,
    };
    *length *= factor;
    changed.check().is_ok().then_some(changed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_axis_is_one_axis() {
        let ball = stretched(&Shape::sphere(0.5), 1, 2.0);
        let radii = [0.5, 1.0, 0.5];
        assert_eq!(ball, Some(Shape::Ellipsoid { radii }));
        let tall = Shape::Cone {
            radius: 0.2,
            height: 1.0,
        };
        assert!(stretched(&tall, 0, 2.0).is_none());
        let taller = Shape::Cone {
            radius: 0.2,
            height: 3.0,
        };
        assert_eq!(stretched(&tall, 1, 3.0), Some(taller));
        // What cannot be is refused.
        assert!(stretched(&tall, 1, 0.0).is_none());
    }
}
