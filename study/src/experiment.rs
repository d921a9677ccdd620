//! Experiments as data.

use crate::configuration::Configuration;
use argil::render::{NormalSource, RenderMode};
use serde_json::Value;

/// A question with all that is tried to answer it.
#[derive(Debug)]
pub struct Experiment {
    /// Its name, in one word.
    pub name: &'static str,
    /// Its title.
    pub title: &'static str,
    /// What is asked.
    pub question: &'static str,
    /// Where the 2023 study has it, and what it found there, in numbers.
    pub study: &'static str,
    /// How much is tried on a device.
    pub cases: fn(&Plan) -> Vec<StudyCase>,
}

/// One thing that is tried.
#[derive(Clone, Debug)]
pub struct StudyCase {
    /// The scene's name.
    pub scene: String,
    /// How it is kept.
    pub way: Configuration,
    /// What is done.
    pub task: Task,
    /// What must come out.
    pub expect: Vec<Expectation>,
}

/// What a value must be.
#[derive(Clone, Copy, Debug)]
pub struct Expectation {
    /// Its name.
    pub value: &'static str,
    /// Least.
    pub min: f64,
    /// Most.
    pub max: f64,
}

/// Where a scene is looked at from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum StudyCamera {
    /// Its own camera.
    #[default]
    Outside,
    /// In the middle of its box.
    Inside,
    /// Along its surface.
    Grazing,
}

impl StudyCamera {
    /// In one word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Outside => "outside",
            Self::Inside => "inside",
            Self::Grazing => "grazing",
        }
    }
}

/// A picture that is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// What is shown.
    pub show: RenderMode,
    /// From where.
    pub eye: StudyCamera,
    /// Bricks: where normals come from.
    pub normals: NormalSource,
    /// Half of a normal's difference, in voxels; the representation's own without it.
    pub bias_voxels: Option<f32>,
    /// Whether it is compared with the field's.
    pub is_compared: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            show: RenderMode::Normal,
            eye: StudyCamera::default(),
            normals: NormalSource::default(),
            bias_voxels: None,
            is_compared: true,
        }
    }
}

/// What is done with a scene.
#[derive(Clone, Copy, Debug)]
pub enum Task {
    /// Build it so many times.
    Build(u32),
    /// Draw so many frames around it.
    Frames(u32, StudyCamera),
    /// Draw a picture.
    Picture(Look),
    /// Compare stored distances with exact ones at so many points.
    Stored(u32),
    /// Compare triangles with the exact surface, at so many points of each.
    Surface(u32),
    /// Cut so many balls out of it, of a radius in parts of the box, one after the other.
    Edits(u32, f32),
    /// Look for bricks that should be there and are not.
    CountLostBricks,
}

impl StudyCase {
    /// A case without expectations.
    pub fn new(scene: impl Into<String>, way: Configuration, task: Task) -> Self {
        Self {
            scene: scene.into(),
            way,
            task,
            expect: Vec::new(),
        }
    }

    /// What a value must be.
    pub fn expect(mut self, value: &'static str, least: f64, most: f64) -> Self {
        self.expect.push(Expectation {
            value,
            min: least,
            max: most,
        });
        self
    }

    /// A name of its own in its experiment.
    pub fn name(&self) -> String {
        let mut name = format!("{}/{}", self.scene, self.way.name());
        for (key, value) in self.parameters() {
            let in_name = [
                "resolution",
                "bits",
                "stride",
                "brick",
                "keep",
                "descent",
                "sort",
                "fill",
            ];
            let in_name = in_name.contains(&key) || value == "face";
            if !in_name {
                name += &format!("/{key}={}", value.to_string().trim_matches('"'));
            }
        }
        name
    }

    /// What is varied besides the scene and the representation.
    pub fn parameters(&self) -> Vec<(&'static str, Value)> {
        use crate::configuration::ConfigurationKind;
        let mut all: Vec<(&'static str, Value)> = Vec::new();
        if !self.way.is_field() {
            all.push(("resolution", self.way.resolution.into()));
        }
        if let ConfigurationKind::Octree { brick, .. } | ConfigurationKind::Bricks { brick } =
            self.way.kind
        {
            all.push(("brick", brick.into()));
        }
        let own = match self.way.kind {
            ConfigurationKind::Octree {
                center,
                path,
                enumerated,
                ..
            } => [
                (center, "keep", "center"),
                (path, "descent", "path"),
                (enumerated, "sort", "enumerated"),
            ],
            ConfigurationKind::Dense { naive, .. } => {
                [(naive, "fill", "naive"), (false, "", ""), (false, "", "")]
            }
            ConfigurationKind::Mesh { flat, .. } => {
                [(flat, "normals", "face"), (false, "", ""), (false, "", "")]
            }
            _ => [(false, "", ""); 3],
        };
        let own = own.into_iter().filter(|(is, _, _)| *is);
        all.extend(own.map(|(_, key, value)| (key, Value::from(value))));
        if let Some(bits) = self.way.bits {
            all.push(("bits", (8 * bits.bytes()).into()));
        }
        if let Some(stride) = self.way.stride {
            all.push(("stride", stride.into()));
        }
        match self.task {
            Task::Picture(look) => {
                let show = match look.show {
                    RenderMode::Shaded => "shaded",
                    RenderMode::Normal => "normal",
                    RenderMode::Depth => "depth",
                    RenderMode::Heat => "heat",
                    RenderMode::Bricks => "bricks",
                    RenderMode::Nodes => "nodes",
                    _ => "another",
                };
                all.push(("show", show.into()));
                all.push(("eye", look.eye.word().into()));
                if look.normals != NormalSource::default() {
                    let word = match look.normals {
                        NormalSource::Voxel => "voxel",
                        NormalSource::Smooth => "smooth",
                        NormalSource::Field => "field",
                    };
                    all.push(("normals", word.into()));
                }
                if let Some(bias) = look.bias_voxels {
                    all.push(("bias_voxels", bias.into()));
                }
            }
            Task::Frames(_, eye) => all.push(("eye", eye.word().into())),
            Task::Edits(_, radius) => {
                let rounded = (f64::from(radius) * 1e6).round() / 1e6;
                all.push(("radius", rounded.into()));
            }
            _ => {}
        }
        all
    }
}

/// How much is measured on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// All that there is, or what a few minutes allow.
    pub full: bool,
    /// A GPU in software takes a hundred times as long as one in hardware.
    pub is_software_gpu: bool,
    /// A GPU of any kind.
    pub is_gpu: bool,
}

impl Plan {
    /// One of three numbers: for a software GPU in a quick run, for anything else in one, and for a full one.
    pub fn pick<T>(&self, software: T, quick: T, full: T) -> T {
        match (self.full, self.is_software_gpu) {
            (true, _) => full,
            (false, true) => software,
            (false, false) => quick,
        }
    }

    /// Pixels of pictures.
    pub fn size(&self) -> [u32; 2] {
        if self.full && self.is_gpu && !self.is_software_gpu {
            [1920, 1080]
        } else {
            self.pick([320, 180], [640, 360], [1280, 720])
        }
    }

    /// Voxels along a side where nothing else is asked for: the study's, where time allows.
    pub fn resolution(&self) -> u32 {
        self.pick(64, 256, 256)
    }

    /// Frames of an orbit: the study's 250 on hardware.
    pub fn frames(&self) -> u32 {
        if self.full && self.is_gpu && !self.is_software_gpu {
            250
        } else {
            self.pick(3, 12, 40)
        }
    }
}
