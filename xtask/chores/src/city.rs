//! A city of instances of instances.

use crate::world_parts::{Random, instances, materials, translate};
use serde_json::{Value, json};

/// Returns 1,000 quarters of 100 blocks each, which are instances of instances.
pub(crate) fn city() -> Value {
    let mut random = Random(7);
    let mut kinds = Vec::new();
    for (index, height) in [18.0, 30.0, 55.0, 90.0].into_iter().enumerate() {
        let block = json!([
            { "material": "plaster", "shape": { "type": "box", "half_size": [14, height, 14] } },
            { "operator": "subtract", "material": "rock", "shape": { "type": "box", "half_size": [6, height, 6] }, "modifiers": [translate([0.0, 6.0, 0.0])] },
            { "material": "tile", "shape": { "type": "box", "half_size": [4, 3, 4] }, "modifiers": [translate([10.0, height + 3.0, -9.0])] },
        ]);
        let cells = (0..100u16).filter(|cell| usize::from(cell * 7 % 4) == index);
        let poses: Vec<[f32; 5]> = cells
            .map(|cell| {
                let (x, z) = (f32::from(cell % 10) - 4.5, f32::from(cell / 10) - 4.5);
                [
                    40.0 * x,
                    0.0,
                    40.0 * z,
                    90.0 * (random.next() * 4.0).floor(),
                    random.choice(&[0.7, 0.85, 1.0]),
                ]
            })
            .collect();
        let parts = block.as_array().cloned().unwrap_or_default();
        kinds.push(instances("blocks", parts, &poses));
    }
    let quarters: Vec<[f32; 5]> = (0..1000u16)
        .map(|index| {
            let (x, z) = (f32::from(index % 32) - 15.5, f32::from(index / 32) - 15.5);
            [
                430.0 * x,
                0.0,
                430.0 * z,
                90.0 * (random.next() * 4.0).floor(),
                1.0,
            ]
        })
        .collect();
    let path = |points: &[(f32, [f32; 3], [f32; 3])]| -> Vec<Value> {
        let point = |(time, eye, target): &(f32, [f32; 3], [f32; 3])| json!({ "time": time, "eye": eye, "target": target });
        points.iter().map(point).collect()
    };
    json!({
        "argil": 1,
        "name": "city",
        "view": {
            "camera": { "look_at": { "eye": [-420, 210, 640], "target": [200, 40, 0] } },
            "field_of_view_degrees": 55,
            "sun_degrees": [70, 40],
            "bounds": [[-7200, -40, -7200], [7200, 400, 7200]],
            "paths": {
                "walk": path(&[(0.0, [0.0, 1.7, 800.0], [0.0, 4.0, 700.0]), (60.0, [0.0, 1.7, 716.0], [0.0, 4.0, 616.0])]),
                "flight": path(&[(0.0, [-900.0, 140.0, 640.0], [-700.0, 100.0, 560.0]), (30.0, [0.0, 140.0, 640.0], [200.0, 100.0, 560.0])]),
            },
        },
        "materials": materials(),
        "brushes": [
            { "name": "ground", "material": "rock", "shape": { "type": "plane", "normal": [0, 1, 0], "offset": 0 } },
            instances("quarters", kinds, &quarters),
        ],
    })
}
