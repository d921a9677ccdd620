//! Experiments as data.

use crate::configuration::Configuration;
use argil::render::{NormalSource, RenderMode};
use serde_json::Value;

/// A question, and the cases that answer it.
#[derive(Debug)]
pub struct Experiment {
    /// The name, one word.
    pub name: &'static str,
    /// The title.
    pub title: &'static str,
    /// The question.
    pub question: &'static str,
    /// The section of the 2023 study, and its result in numbers.
    pub study: &'static str,
    /// Returns the cases for a device.
    pub cases: fn(&Plan) -> Vec<StudyCase>,
}

/// A case.
#[derive(Clone, Debug)]
pub struct StudyCase {
    /// Name of the scene.
    pub scene: String,
    /// The configuration.
    pub way: Configuration,
    /// The task.
    pub task: Task,
    /// Expected results.
    pub expect: Vec<Expectation>,
}

/// An expected range of a value.
#[derive(Clone, Copy, Debug)]
pub struct Expectation {
    /// Name of the value.
    pub value: &'static str,
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
}

/// The camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum StudyCamera {
    /// The scene's own camera.
    #[default]
    Outside,
    /// A camera in the middle of the scene's box.
    Inside,
    /// A camera along the surface.
    Grazing,
}

impl StudyCamera {
    /// Returns the camera as a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Outside => "outside",
            Self::Inside => "inside",
            Self::Grazing => "grazing",
        }
    }
}

/// Samples of each pixel of an image to look at closely.
pub(crate) const CLOSE_SAMPLES: u32 = 4;

/// An image to render.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// The render mode.
    pub show: RenderMode,
    /// The camera.
    pub eye: StudyCamera,
    /// Bricks: source of normals.
    pub normals: NormalSource,
    /// Half the step of a normal's difference in voxels. `None` is the representation's default.
    pub bias_voxels: Option<f32>,
    /// Whether it is compared with the field's image.
    pub is_compared: bool,
    /// Whether to look closely: 4 samples a pixel, the ground where there is light, and a precise image of the field.
    pub is_close: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            show: RenderMode::Normal,
            eye: StudyCamera::default(),
            normals: NormalSource::default(),
            bias_voxels: None,
            is_compared: true,
            is_close: false,
        }
    }
}

/// A task.
#[derive(Clone, Copy, Debug)]
pub enum Task {
    /// Builds a number of times.
    Build(u32),
    /// Renders a number of frames around the scene.
    Frames(u32, StudyCamera),
    /// Renders an image.
    Picture(Look),
    /// Compares stored distances with exact ones at a number of points.
    Stored(u32),
    /// Compares triangles with the exact surface, at a number of points of each.
    Surface(u32),
    /// Cuts a number of balls out of the scene, one after another. Their radius is a fraction of the box.
    Edits(u32, f32),
    /// Counts bricks that the study's test loses.
    CountLostBricks,
}

impl StudyCase {
    /// Creates a case without expectations.
    pub fn new(scene: impl Into<String>, way: Configuration, task: Task) -> Self {
        Self {
            scene: scene.into(),
            way,
            task,
            expect: Vec::new(),
        }
    }

    /// Adds an expected range of a value.
    pub fn expect(mut self, value: &'static str, least: f64, most: f64) -> Self {
        self.expect.push(Expectation {
            value,
            min: least,
            max: most,
        });
        self
    }

    /// Returns a name that is unique in the experiment.
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

    /// Returns what varies besides scene and representation.
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
                if look.is_close {
                    all.push(("samples", CLOSE_SAMPLES.into()));
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

/// The amount of measurements for a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Whether to measure everything, instead of a few minutes' worth.
    pub full: bool,
    /// Whether the device is a software GPU, which takes about a hundred times as long as hardware.
    pub is_software_gpu: bool,
    /// Whether the device is a GPU.
    pub is_gpu: bool,
}

impl Plan {
    /// Returns one of three values: for a software GPU in a quick run, for another device in a quick run, or for a
    /// full run.
    pub fn pick<T>(&self, software: T, quick: T, full: T) -> T {
        match (self.full, self.is_software_gpu) {
            (true, _) => full,
            (false, true) => software,
            (false, false) => quick,
        }
    }

    /// Returns the size of images in pixels.
    pub fn size(&self) -> [u32; 2] {
        if self.full && self.is_gpu && !self.is_software_gpu {
            [1920, 1080]
        } else {
            self.pick([320, 180], [640, 360], [1280, 720])
        }
    }

    /// Returns the default voxels along a side: the study's, where time allows.
    pub fn resolution(&self) -> u32 {
        self.pick(64, 256, 256)
    }

    /// Returns the frames of an orbit: the study's 250 on hardware.
    pub fn frames(&self) -> u32 {
        if self.full && self.is_gpu && !self.is_software_gpu {
            250
        } else {
            self.pick(3, 12, 40)
        }
    }
}
