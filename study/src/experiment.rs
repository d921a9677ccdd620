//! Experiments as data.

use crate::configuration::Configuration;
use crate::plan::Plan;
use crate::task::{FrameSeries, Task};
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
    /// Which cases are compared, and so measured in one sitting.
    pub compared: Compared,
    /// Returns the cases for a device.
    pub cases: fn(&Plan) -> Vec<StudyCase>,
}

/// Which cases of an experiment are compared with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// All.
    All,
    /// Those of one scene, task, camera, light and resolution.
    SameScene,
    /// Those of one resolution.
    SameResolution,
    /// None: their times are not compared.
    Apart,
}

impl Compared {
    /// Returns the name of the group of a case. Cases of one group are measured in one sitting.
    pub fn group(self, case: &StudyCase) -> String {
        let resolution = case.way.resolution;
        match self {
            Self::All => String::new(),
            Self::SameResolution => format!("{resolution}"),
            Self::Apart => format!("{}/{}", case.name(), case.task.word()),
            Self::SameScene => {
                let series = match case.task {
                    Task::Frames(series) => format!("{series:?}"),
                    Task::Picture(look) => format!("{look:?}"),
                    _ => String::new(),
                };
                let task = case.task.word();
                format!("{}/{resolution}/{task}/{series}", case.scene)
            }
        }
    }
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
                "size",
            ];
            let in_name = in_name.contains(&key) || value == "face";
            if !in_name {
                name += &format!("/{key}={}", value.to_string().trim_matches('"'));
            }
        }
        if let Task::Frames(FrameSeries {
            size: Some([width, height]),
            ..
        }) = self.task
        {
            name += &format!("/{width}x{height}");
        }
        name
    }

    /// Returns what varies besides scene and representation.
    pub fn parameters(&self) -> Vec<(&'static str, Value)> {
        use crate::configuration::ConfigurationKind;
        let mut all: Vec<(&'static str, Value)> = Vec::new();
        if self.way.kind == ConfigurationKind::FidgetWgpu {
            let size = vec![self.way.resolution; 2];
            all.push(("size", size.into()));
        } else if !self.way.is_field() {
            all.push(("resolution", self.way.resolution.into()));
        }
        if let ConfigurationKind::Octree { brick, .. } | ConfigurationKind::Bricks { brick } =
            self.way.kind
        {
            all.push(("brick", brick.into()));
        }
        let parameters_of_kind = match self.way.kind {
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
        let parameters_of_kind = parameters_of_kind.into_iter().filter(|(is, _, _)| *is);
        all.extend(parameters_of_kind.map(|(_, key, value)| (key, Value::from(value))));
        if let Some(bits) = self.way.bits {
            all.push(("bits", (8 * bits.bytes()).into()));
        }
        if let Some(stride) = self.way.stride {
            all.push(("stride", stride.into()));
        }
        all.extend(self.task.parameters());
        all
    }
}
