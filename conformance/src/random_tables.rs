//! Random scenes and edits whose shapes, operators and modifiers come from the whole tables.
//!
//! A row's example is changed at random, number by number, through its form in a file. So a new row takes part by being
//! a row. What its checks refuse is drawn again.

use crate::CaseRng;
use crate::shape_cases::{heights, sampled, vase};
use argil_scene::{
    BlendProfile, Brush, Curve, Edit, Group, Modifier, MorphRamp, NodeDesc, NodeId, NodeKind,
    Operator, OperatorKind, Ramp, Scene, Shape,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// All operators. The compiler refuses a new one that is missing here.
const OPERATORS: [OperatorKind; 5] = {
    match OperatorKind::Union {
        OperatorKind::Union
        | OperatorKind::Subtract
        | OperatorKind::Intersect
        | OperatorKind::Paint
        | OperatorKind::Morph => {}
    }
    [
        OperatorKind::Union,
        OperatorKind::Subtract,
        OperatorKind::Intersect,
        OperatorKind::Paint,
        OperatorKind::Morph,
    ]
};

/// A source of random rows, scenes and edits.
#[derive(Debug)]
pub struct RandomTables {
    numbers: CaseRng,
    shapes: Vec<Shape>,
    modifiers: Vec<Modifier>,
}

impl RandomTables {
    /// Creates a source from a seed.
    pub fn new(seed: u64) -> Self {
        let outline = vase();
        let special = [Shape::Lathe { outline }, sampled(), heights()];
        Self {
            numbers: CaseRng::new(seed),
            shapes: Shape::examples().into_iter().chain(special).collect(),
            modifiers: Modifier::examples(),
        }
    }

    /// Returns a random index below a count.
    pub fn pick(&mut self, count: usize) -> usize {
        ((self.numbers.unit() * count as f32) as usize).min(count.saturating_sub(1))
    }

    /// Returns true with a probability.
    pub fn chance(&mut self, probability: f32) -> bool {
        self.numbers.unit() < probability
    }

    /// Returns a random point in a cube around the origin.
    pub fn point(&mut self, half: f32) -> [f32; 3] {
        self.numbers.point(half).to_array()
    }

    /// Changes numbers of a value, until its check accepts the result. After eight refusals, it returns the value.
    fn varied<T: Clone + Serialize + DeserializeOwned>(
        &mut self,
        value: &T,
        is_valid: impl Fn(&T) -> bool,
    ) -> T {
        let json = serde_json::to_value(value).expect("a value with a form in files");
        for attempt in 0..8 {
            let mut json = json.clone();
            self.vary(&mut json, 0.9 / (1.0 + attempt as f32));
            if let Some(varied) = serde_json::from_value(json).ok().filter(&is_valid) {
                return varied;
            }
        }
        value.clone()
    }

    /// Changes each number with a probability.
    fn vary(&mut self, json: &mut Value, probability: f32) {
        match json {
            Value::Array(all) => all.iter_mut().for_each(|v| self.vary(v, probability)),
            Value::Object(all) => all.values_mut().for_each(|v| self.vary(v, probability)),
            Value::Bool(flag) if self.chance(0.4 * probability) => *flag = !*flag,
            Value::Number(number) if self.chance(probability) => {
                *json = if let Some(count) = number.as_u64() {
                    Value::from(self.pick(count.min(6) as usize + 3))
                } else {
                    let old = number.as_f64().unwrap_or(0.0) as f32;
                    let factor = self.numbers.between(0.3, 1.9);
                    let shift = if self.chance(0.3) {
                        self.numbers.between(-0.3, 0.3)
                    } else {
                        0.0
                    };
                    let sign = if self.chance(0.15) { -1.0 } else { 1.0 };
                    Value::from(f64::from(sign * old * factor + shift))
                };
            }
            _ => {}
        }
    }

    /// Returns a random shape of any row.
    pub fn shape(&mut self) -> Shape {
        let row = self.pick(self.shapes.len());
        let shape = self.shapes[row].clone();
        if shape.file().is_some() {
            // Its numbers belong to its samples.
            return shape;
        }
        self.varied(&shape, |shape| shape.check().is_ok())
    }

    /// Returns a random modifier of any row.
    pub fn modifier(&mut self) -> Modifier {
        let row = self.pick(self.modifiers.len());
        let modifier = self.modifiers[row].clone();
        match self.varied(&modifier, |modifier| modifier.check().is_ok()) {
            // Many copies test nothing more than few.
            Modifier::Displace {
                frequency,
                amplitude,
                seed,
                octaves,
            } => Modifier::Displace {
                amplitude,
                frequency: frequency.min(8.0),
                seed,
                octaves,
            },
            other => other,
        }
    }

    /// Returns a random operator.
    pub fn operator(&mut self) -> Operator {
        let blend = if self.chance(0.5) {
            self.numbers.between(0.0, 0.3)
        } else {
            0.0
        };
        let profile = if self.chance(0.2) {
            BlendProfile::Chamfer
        } else {
            BlendProfile::Smooth
        };
        // Half of the solids are added, so that others have something to change.
        let kind = if self.chance(0.5) {
            OperatorKind::Union
        } else {
            OPERATORS[self.pick(OPERATORS.len())]
        };
        let morph_amount = if self.chance(0.2) {
            0.0
        } else {
            self.numbers.unit()
        };
        Operator {
            kind,
            blend,
            profile,
            morph_amount,
        }
    }

    /// Returns a random brush, or an empty group.
    pub fn desc(&mut self) -> NodeDesc {
        let mut desc: NodeDesc = if self.chance(0.2) {
            Group::new().into()
        } else {
            Brush::new(self.shape()).into()
        };
        let count = [0, 1, 1, 2, 3][self.pick(5)];
        desc.modifiers = (0..count).map(|_| self.modifier()).collect();
        desc.modifiers.push(Modifier::Translate {
            by: self.point(0.7),
        });
        desc.operator = self.operator();
        if desc.operator.kind == OperatorKind::Morph && self.chance(0.3) {
            desc.ramp = Some(Box::new(self.morph_ramp()));
        }
        desc.visible = !self.chance(0.05);
        desc
    }

    fn morph_ramp(&mut self) -> MorphRamp {
        let curve = Curve::linear();
        let ramp = if self.chance(0.5) {
            Ramp::Line {
                from: self.point(1.0),
                to: self.point(1.0),
                curve,
            }
        } else {
            Ramp::Radius {
                from: 0.8,
                to: 0.1,
                curve,
            }
        };
        let along = self.varied(&ramp, |_| true);
        MorphRamp {
            along,
            max_difference: self.numbers.between(0.05, 1.0),
        }
    }

    /// Returns a random group of a scene.
    fn group(&mut self, scene: &Scene) -> NodeId {
        let is_group = |&node: &NodeId| scene.node(node).desc().kind == NodeKind::Group;
        let groups: Vec<NodeId> = scene.iter().filter(is_group).collect();
        if self.chance(0.4) {
            Scene::ROOT
        } else {
            groups[self.pick(groups.len())]
        }
    }

    /// Returns a random scene with a ball and a number of nodes, nested in groups.
    pub fn scene(&mut self, nodes: usize) -> Scene {
        let mut scene = Scene::new();
        let ball = Brush::new(Shape::sphere(0.2)).at(self.point(0.5));
        scene.push(ball).expect("a valid brush");
        for _ in 0..nodes {
            let (group, desc) = (self.group(&scene), self.desc());
            // What is refused changes nothing.
            let _ = scene.push_into(group, desc);
        }
        scene
    }

    /// Applies a random edit of any kind, an undo or a redo.
    pub fn edit(&mut self, scene: &mut Scene) {
        let nodes: Vec<NodeId> = scene.iter().filter(|&node| node != Scene::ROOT).collect();
        let parent = self.group(scene);
        let index = self.pick(scene.node(parent).children().len() + 1);
        let insert = Edit::Insert {
            parent,
            index,
            desc: self.desc(),
        };
        if nodes.is_empty() {
            let _ = scene.apply(insert);
            return;
        }
        let node = nodes[self.pick(nodes.len())];
        let mut desc = scene.node(node).desc().clone();
        let edit = match self.pick(12) {
            0 | 1 if nodes.len() < 14 => insert,
            0..=2 => Edit::Remove { node },
            3 => Edit::SetVisible {
                node,
                visible: !desc.visible,
            },
            4 => Edit::Transform {
                node,
                by: Modifier::Translate {
                    by: self.point(0.3),
                },
            },
            5 => Edit::Move {
                node,
                parent,
                index,
            },
            6 => {
                scene.undo();
                return;
            }
            7 => {
                scene.redo();
                return;
            }
            8 => {
                desc.operator = self.operator();
                Edit::Replace { node, desc }
            }
            9 => {
                let at = self.pick(desc.modifiers.len() + 1);
                let modifier = self.modifier();
                desc.modifiers.insert(at, modifier);
                Edit::Replace { node, desc }
            }
            10 => {
                let count = desc.modifiers.len();
                desc.modifiers.truncate(self.pick(count + 1));
                Edit::Replace { node, desc }
            }
            _ => {
                let kind = self.desc().kind;
                desc.kind = kind;
                Edit::Replace { node, desc }
            }
        };
        // What is refused changes nothing.
        let _ = scene.apply(edit);
    }
}
