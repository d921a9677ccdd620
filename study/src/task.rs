//! Tasks of cases.

use argil::render::{NormalSource, RenderMode};
use serde_json::Value;

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

/// Paths of each pixel of a still, which is enough to take its time.
pub(crate) const STILL_PATHS: u32 = 4;

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

/// Frames around a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameSeries {
    /// The number of frames.
    pub count: u32,
    /// The camera of the first.
    pub eye: StudyCamera,
    /// Whether frames are shaded, with shadows and the scene's ground. Otherwise they show normals.
    pub is_lit: bool,
    /// The size in pixels. `None` is the size of the plan.
    pub size: Option<[u32; 2]>,
}

/// What a program uses a GPU for first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstUse {
    /// Baking bricks.
    Bake,
    /// A frame of bricks with normals.
    Frame,
    /// A frame of bricks with light.
    LitFrame,
    /// A frame of the field with normals.
    FieldFrame,
    /// Baking bricks and an edit.
    Edit,
    /// Triangles.
    Mesh,
}

impl FirstUse {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Bake,
        Self::Frame,
        Self::LitFrame,
        Self::FieldFrame,
        Self::Edit,
        Self::Mesh,
    ];

    /// Returns the use as a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Bake => "bake",
            Self::Frame => "frame",
            Self::LitFrame => "lit-frame",
            Self::FieldFrame => "field-frame",
            Self::Edit => "edit",
            Self::Mesh => "mesh",
        }
    }
}

/// A task.
#[derive(Clone, Copy, Debug)]
pub enum Task {
    /// Builds a number of times.
    Build(u32),
    /// Renders frames around the scene.
    Frames(FrameSeries),
    /// Renders an image.
    Picture(Look),
    /// Compares stored distances with exact ones at a number of points.
    Stored(u32),
    /// Extracts triangles, and compares them with the exact surface at a number of points of each.
    Surface(u32),
    /// Cuts a number of balls out of the scene, one after another. Their radius is a fraction of the box.
    Edits(u32, f32),
    /// Counts bricks that the study's test loses.
    CountLostBricks,
    /// Opens the GPU, and uses it for the first and the second time.
    FirstUse(FirstUse),
    /// Makes stills of a few paths a pixel, a number of times.
    Still(u32),
    /// Runs another renderer a number of times. The resolution is the pixels along a side of its image.
    Peer(u32),
}

impl Task {
    /// Returns the task as a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Build(_) => "build",
            Self::Frames(_) => "frames",
            Self::Picture(_) => "picture",
            Self::Stored(_) => "stored",
            Self::Surface(_) => "surface",
            Self::Edits(..) => "edits",
            Self::CountLostBricks => "lost",
            Self::FirstUse(_) => "first-use",
            Self::Still(_) => "still",
            Self::Peer(_) => "peer",
        }
    }

    /// Returns what varies.
    pub fn parameters(&self) -> Vec<(&'static str, Value)> {
        let mut all: Vec<(&'static str, Value)> = Vec::new();
        match *self {
            Self::Picture(look) => {
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
            Self::Frames(series) => {
                all.push(("eye", series.eye.word().into()));
                if series.is_lit {
                    all.push(("light", true.into()));
                }
                if let Some(size) = series.size {
                    all.push(("size", size.to_vec().into()));
                }
            }
            Self::Still(_) => all.push(("paths", STILL_PATHS.into())),
            Self::FirstUse(kind) => all.push(("use", kind.word().into())),
            Self::Edits(_, radius) => {
                let rounded = (f64::from(radius) * 1e6).round() / 1e6;
                all.push(("radius", rounded.into()));
            }
            _ => {}
        }
        all
    }
}
