//! Configurations: how a scene is stored during a measurement.

use argil::render::LookupStart;
use argil::volume::{Band, BrickOrdering, BrickTest, DenseFill, Encoding, SampleFormat};
use argil::{
    BricksOptions, DenseOptions, MeshMethod, MeshRenderOptions, OctreeOptions, Representation,
};

/// A representation, with everything that an experiment varies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Configuration {
    /// The representation and its own options.
    pub kind: ConfigurationKind,
    /// Voxels along the longest side.
    pub resolution: u32,
    /// Bits of a stored distance. `None` is the representation's default.
    pub bits: Option<SampleFormat>,
    /// The study's texture stride. `None` is the representation's default band.
    pub stride: Option<u32>,
}

/// The representations and their options.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ConfigurationKind {
    /// The exact field.
    #[default]
    Field,
    /// The exact field, compiled into a shader.
    Compiled,
    /// A dense volume.
    Dense {
        /// With mips.
        mips: bool,
        /// Filled with one thread per group, as the study did first.
        naive: bool,
    },
    /// The study's octree.
    Octree {
        /// Voxels along a brick's side.
        brick: u32,
        /// Whether bricks are tested by their centers, as in the study.
        center: bool,
        /// Whether look-ups start where the last one ended.
        path: bool,
        /// Whether bricks are ordered by the study's enumeration sort, which is quadratic.
        enumerated: bool,
    },
    /// Sparse bricks.
    Bricks {
        /// Voxels along a brick's side.
        brick: u32,
    },
    /// As many triangles as fit into the bytes of a dense 8-bit volume of the resolution.
    MeshAsLarge,
    /// Triangles.
    Mesh {
        /// By dual contouring.
        dual: bool,
        /// With face normals: the study's true normals.
        flat: bool,
    },
    /// Another renderer: fidget's for the GPU. The resolution is the pixels along a side of its image.
    FidgetWgpu,
}

/// The study's octree: bricks of 32³, and look-ups from the root.
pub const STUDY_OCTREE: ConfigurationKind = ConfigurationKind::Octree {
    brick: 32,
    center: false,
    path: false,
    enumerated: false,
};

/// Sparse bricks with default options.
pub const BRICKS: ConfigurationKind = ConfigurationKind::Bricks { brick: 8 };

/// A dense volume.
pub const DENSE: ConfigurationKind = ConfigurationKind::Dense {
    mips: false,
    naive: false,
};

/// A dense volume with mips.
pub const MIPPED: ConfigurationKind = ConfigurationKind::Dense {
    mips: true,
    naive: false,
};

/// Triangles with the field's normals.
pub const MESH: ConfigurationKind = ConfigurationKind::Mesh {
    dual: false,
    flat: false,
};

impl Configuration {
    /// Creates a configuration at a resolution.
    pub fn of(kind: ConfigurationKind, resolution: u32) -> Self {
        Self {
            kind,
            resolution,
            ..Self::default()
        }
    }

    /// Sets the bits.
    pub fn bits(mut self, bits: SampleFormat) -> Self {
        self.bits = Some(bits);
        self
    }

    /// Sets the study's stride.
    pub fn stride(mut self, stride: u32) -> Self {
        self.stride = Some(stride);
        self
    }

    fn encoding(&self, usual: Encoding) -> Encoding {
        let bits = self.bits.unwrap_or(usual.format);
        let range = match self.stride {
            Some(stride) => Band::Stride(stride),
            None if bits == usual.format => usual.band,
            None => Band::default(),
        };
        Encoding {
            format: bits,
            band: range,
        }
    }

    /// Returns the engine's representation.
    pub fn via(&self) -> Representation {
        let resolution = self.resolution;
        match self.kind {
            ConfigurationKind::Field
            | ConfigurationKind::Compiled
            | ConfigurationKind::FidgetWgpu => Representation::Field,
            // It is resolved before the build.
            ConfigurationKind::MeshAsLarge => Representation::Mesh(MeshRenderOptions {
                resolution,
                ..MeshRenderOptions::default()
            }),
            ConfigurationKind::Dense { mips, naive } => Representation::Dense(DenseOptions {
                resolution,
                encoding: self.encoding(Encoding::default()),
                mips,
                fill: if naive {
                    DenseFill::Naive
                } else {
                    DenseFill::Tiled
                },
            }),
            ConfigurationKind::Octree {
                brick,
                center,
                enumerated,
                ..
            } => {
                let mut options = OctreeOptions {
                    resolution,
                    ..OctreeOptions::default()
                };
                options.settings.encoding = self.encoding(options.settings.encoding);
                options.settings.brick_size_voxels = brick;
                if center {
                    options.settings.brick_test = BrickTest::CenterInBand;
                }
                if enumerated {
                    options.order = BrickOrdering::EnumerationSort;
                }
                Representation::Octree(options)
            }
            ConfigurationKind::Bricks { brick } => {
                let mut options = BricksOptions {
                    resolution,
                    ..BricksOptions::default()
                };
                options.settings.encoding = self.encoding(options.settings.encoding);
                options.settings.brick_size_voxels = brick;
                Representation::Bricks(options)
            }
            ConfigurationKind::Mesh { dual, flat } => Representation::Mesh(MeshRenderOptions {
                resolution,
                method: if dual {
                    MeshMethod::DualContouring
                } else {
                    MeshMethod::MarchingCubes
                },
                flat,
            }),
        }
    }

    /// Returns where look-ups of rays start.
    pub fn descent(&self) -> LookupStart {
        match self.kind {
            ConfigurationKind::Octree { path: true, .. } => LookupStart::Path,
            _ => LookupStart::Root,
        }
    }

    /// Returns true if nothing is stored.
    pub fn is_field(&self) -> bool {
        matches!(
            self.kind,
            ConfigurationKind::Field | ConfigurationKind::Compiled
        )
    }

    /// Returns an upper estimate of the memory of a representation in bytes.
    pub fn estimated_bytes(&self) -> u64 {
        let side = u64::from(self.resolution);
        let bits = self.bits.map_or(1, |bits| bits.bytes() as u64);
        match self.kind {
            ConfigurationKind::Field
            | ConfigurationKind::Compiled
            | ConfigurationKind::FidgetWgpu => 0,
            ConfigurationKind::Dense { .. }
            | ConfigurationKind::Octree { .. }
            | ConfigurationKind::MeshAsLarge => side.pow(3) * bits * 8 / 7,
            ConfigurationKind::Bricks { .. } | ConfigurationKind::Mesh { .. } => 256 * side.pow(2),
        }
    }

    /// Returns the representation as a word.
    pub fn label(&self) -> &'static str {
        match self.kind {
            ConfigurationKind::Field => "field",
            ConfigurationKind::Compiled => "field, compiled",
            ConfigurationKind::MeshAsLarge => "mesh as large as dense",
            ConfigurationKind::Dense { mips: false, .. } => "dense",
            ConfigurationKind::Dense { .. } => "dense, mips",
            ConfigurationKind::Octree { .. } => "octree",
            ConfigurationKind::Bricks { .. } => "bricks",
            ConfigurationKind::Mesh { dual: false, .. } => "mesh",
            ConfigurationKind::Mesh { .. } => "mesh, dual",
            ConfigurationKind::FidgetWgpu => "fidget-wgpu",
        }
    }

    /// Returns a name that includes everything varied.
    pub fn name(&self) -> String {
        let mut name = self.label().replace(", ", "-").replace(' ', "-");
        if !self.is_field() {
            name += &format!("-{}", self.resolution);
        }
        match self.kind {
            ConfigurationKind::Octree {
                brick,
                center,
                path,
                enumerated,
            } => {
                name += &format!("-b{brick}");
                for (is, word) in [(center, "-center"), (path, "-path"), (enumerated, "-sort")] {
                    name += if is { word } else { "" };
                }
            }
            ConfigurationKind::Bricks { brick } if brick != 8 => name += &format!("-b{brick}"),
            ConfigurationKind::Dense { naive: true, .. } => name += "-naive",
            ConfigurationKind::Mesh { flat: true, .. } => name += "-flat",
            _ => {}
        }
        if let Some(bits) = self.bits {
            name += &format!("-{}bit", 8 * bits.bytes());
        }
        if let Some(stride) = self.stride {
            name += &format!("-stride{stride}");
        }
        name
    }

    /// Returns the command's flags for this configuration.
    pub fn flags(&self, on_gpu: bool) -> String {
        let mut flags = String::new();
        let mut add = |flag: &str| {
            flags.push(' ');
            flags.push_str(flag);
        };
        match self.kind {
            ConfigurationKind::Field | ConfigurationKind::FidgetWgpu => return flags,
            ConfigurationKind::Compiled => {
                add("--specialize");
                return flags;
            }
            ConfigurationKind::MeshAsLarge => add("--via mesh"),
            ConfigurationKind::Dense { mips, naive } => {
                add("--via dense");
                if mips {
                    add("--mips");
                }
                if naive && on_gpu {
                    add("--fill naive");
                }
            }
            ConfigurationKind::Octree {
                brick,
                center,
                path,
                enumerated,
            } => {
                add(&format!("--via octree --brick {brick}"));
                add(if path {
                    "--descent path"
                } else {
                    "--descent root"
                });
                if center {
                    add("--keep center");
                }
                if enumerated && on_gpu {
                    add("--sort enumerated");
                }
            }
            ConfigurationKind::Bricks { brick } => add(&format!("--via bricks --brick {brick}")),
            ConfigurationKind::Mesh { dual, flat } => {
                add("--via mesh");
                if dual {
                    add("--method dc");
                }
                if flat {
                    add("--flat");
                }
            }
        }
        add(&format!("--resolution {}", self.resolution));
        if let Some(bits) = self.bits {
            add(&format!("--bits {}", 8 * bits.bytes()));
        }
        if let Some(stride) = self.stride {
            add(&format!("--stride {stride}"));
        }
        flags
    }
}
