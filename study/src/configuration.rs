//! How a scene is kept while it is measured.

use argil::gpu::{BrickOrdering, DenseFill};
use argil::render::LookupStart;
use argil::volume::{Band, BrickTest, Encoding, SampleFormat};
use argil::{
    BricksOptions, DenseOptions, MeshMethod, MeshRenderOptions, OctreeOptions, Representation,
};

/// How a scene is kept, with all that an experiment varies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Configuration {
    /// Field, dense, octree, bricks or mesh, with its own options.
    pub kind: ConfigurationKind,
    /// Voxels along the longest side.
    pub resolution: u32,
    /// Bits of a stored distance; the representation's own without it.
    pub bits: Option<SampleFormat>,
    /// The study's texture stride; the representation's own band without it.
    pub stride: Option<u32>,
}

/// The representations and their options.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ConfigurationKind {
    /// The exact field.
    #[default]
    Field,
    /// The same, compiled into a GPU's shader.
    Compiled,
    /// One texture.
    Dense {
        /// With mips.
        mips: bool,
        /// A thread a group, as the study filled its first volume.
        naive: bool,
    },
    /// The study's structure.
    Octree {
        /// Voxels along a brick's side.
        brick: u32,
        /// The study's test of bricks by their centers.
        center: bool,
        /// Look-ups begin where the last one ended.
        path: bool,
        /// The study's sort, which is quadratic.
        enumerated: bool,
    },
    /// The product's structure.
    Bricks {
        /// Voxels along a brick's side.
        brick: u32,
    },
    /// As many triangles as take the bytes of a dense volume of 8 bits at the resolution.
    MeshAsLarge,
    /// Triangles.
    Mesh {
        /// By dual contouring.
        dual: bool,
        /// With normals of their own: the study's true ones.
        flat: bool,
    },
}

/// The study's octree: bricks of 32³, each look-up from the root.
pub const STUDY_OCTREE: ConfigurationKind = ConfigurationKind::Octree {
    brick: 32,
    center: false,
    path: false,
    enumerated: false,
};

/// Bricks as they come.
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
    /// A kind at a resolution.
    pub fn of(kind: ConfigurationKind, resolution: u32) -> Self {
        Self {
            kind,
            resolution,
            ..Self::default()
        }
    }

    /// With other bits.
    pub fn bits(mut self, bits: SampleFormat) -> Self {
        self.bits = Some(bits);
        self
    }

    /// With the study's stride.
    pub fn stride(mut self, stride: u32) -> Self {
        self.stride = Some(stride);
        self
    }

    fn encoding(&self, own: Encoding) -> Encoding {
        let bits = self.bits.unwrap_or(own.format);
        let range = match self.stride {
            Some(stride) => Band::Stride(stride),
            None if bits == own.format => own.band,
            None => Band::default(),
        };
        Encoding {
            format: bits,
            band: range,
        }
    }

    /// What the engine is told.
    pub fn via(&self) -> Representation {
        let resolution = self.resolution;
        match self.kind {
            ConfigurationKind::Field | ConfigurationKind::Compiled => Representation::Field,
            // It is resolved before it is built.
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
                    options.settings.brick_test = BrickTest::CenterInRange;
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

    /// Where look-ups of rays begin.
    pub fn descent(&self) -> LookupStart {
        match self.kind {
            ConfigurationKind::Octree { path: true, .. } => LookupStart::Path,
            _ => LookupStart::Root,
        }
    }

    /// Whether nothing is stored.
    pub fn is_field(&self) -> bool {
        matches!(
            self.kind,
            ConfigurationKind::Field | ConfigurationKind::Compiled
        )
    }

    /// The representation in one word.
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
        }
    }

    /// The same with everything that is varied, as a name.
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

    /// The flags of the command that keep a scene so.
    pub fn flags(&self, on_gpu: bool) -> String {
        let mut flags = String::new();
        let mut add = |flag: &str| {
            flags.push(' ');
            flags.push_str(flag);
        };
        match self.kind {
            ConfigurationKind::Field => return flags,
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
