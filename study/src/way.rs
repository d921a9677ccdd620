//! How a scene is kept while it is measured.

use argil::{
    Bits, BricksOptions, DenseFill, DenseOptions, Descent, Encoding, Keep, MeshMethod,
    MeshViaOptions, OctreeOptions, Order, Range, Via,
};

/// How a scene is kept, with all that an experiment varies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Way {
    /// Field, dense, octree, bricks or mesh, with its own options.
    pub kind: Kind,
    /// Voxels along the longest side.
    pub resolution: u32,
    /// Bits of a stored distance; the representation's own without it.
    pub bits: Option<Bits>,
    /// The study's texture stride; the representation's own band without it.
    pub stride: Option<u32>,
}

/// The representations and their options.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Kind {
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
        /// The study's test of bricks by their centres.
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
pub const STUDY_OCTREE: Kind = Kind::Octree {
    brick: 32,
    center: false,
    path: false,
    enumerated: false,
};

/// Bricks as they come.
pub const BRICKS: Kind = Kind::Bricks { brick: 8 };

/// A dense volume.
pub const DENSE: Kind = Kind::Dense {
    mips: false,
    naive: false,
};

/// A dense volume with mips.
pub const MIPPED: Kind = Kind::Dense {
    mips: true,
    naive: false,
};

/// Triangles with the field's normals.
pub const MESH: Kind = Kind::Mesh {
    dual: false,
    flat: false,
};

impl Way {
    /// A kind at a resolution.
    pub fn of(kind: Kind, resolution: u32) -> Self {
        Self {
            kind,
            resolution,
            ..Self::default()
        }
    }

    /// With other bits.
    pub fn bits(mut self, bits: Bits) -> Self {
        self.bits = Some(bits);
        self
    }

    /// With the study's stride.
    pub fn stride(mut self, stride: u32) -> Self {
        self.stride = Some(stride);
        self
    }

    fn encoding(&self, own: Encoding) -> Encoding {
        let bits = self.bits.unwrap_or(own.bits);
        let range = match self.stride {
            Some(stride) => Range::Stride(stride),
            None if bits == own.bits => own.range,
            None => Range::default(),
        };
        Encoding { bits, range }
    }

    /// What the engine is told.
    pub fn via(&self) -> Via {
        let resolution = self.resolution;
        match self.kind {
            Kind::Field | Kind::Compiled => Via::Field,
            // It is resolved before it is built.
            Kind::MeshAsLarge => Via::Mesh(MeshViaOptions {
                resolution,
                ..MeshViaOptions::default()
            }),
            Kind::Dense { mips, naive } => Via::Dense(DenseOptions {
                resolution,
                encoding: self.encoding(Encoding::default()),
                mips,
                fill: if naive {
                    DenseFill::Naive
                } else {
                    DenseFill::Tiled
                },
            }),
            Kind::Octree {
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
                options.settings.brick = brick;
                if center {
                    options.settings.keep = Keep::CenterInRange;
                }
                if enumerated {
                    options.order = Order::Enumerated;
                }
                Via::Octree(options)
            }
            Kind::Bricks { brick } => {
                let mut options = BricksOptions {
                    resolution,
                    ..BricksOptions::default()
                };
                options.settings.encoding = self.encoding(options.settings.encoding);
                options.settings.brick = brick;
                Via::Bricks(options)
            }
            Kind::Mesh { dual, flat } => Via::Mesh(MeshViaOptions {
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
    pub fn descent(&self) -> Descent {
        match self.kind {
            Kind::Octree { path: true, .. } => Descent::Path,
            _ => Descent::Root,
        }
    }

    /// Whether nothing is stored.
    pub fn is_field(&self) -> bool {
        matches!(self.kind, Kind::Field | Kind::Compiled)
    }

    /// The representation in one word.
    pub fn word(&self) -> &'static str {
        match self.kind {
            Kind::Field => "field",
            Kind::Compiled => "field, compiled",
            Kind::MeshAsLarge => "mesh as large as dense",
            Kind::Dense { mips: false, .. } => "dense",
            Kind::Dense { .. } => "dense, mips",
            Kind::Octree { .. } => "octree",
            Kind::Bricks { .. } => "bricks",
            Kind::Mesh { dual: false, .. } => "mesh",
            Kind::Mesh { .. } => "mesh, dual",
        }
    }

    /// The same with everything that is varied, as a name.
    pub fn name(&self) -> String {
        let mut name = self.word().replace(", ", "-").replace(' ', "-");
        if !self.is_field() {
            name += &format!("-{}", self.resolution);
        }
        match self.kind {
            Kind::Octree {
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
            Kind::Bricks { brick } if brick != 8 => name += &format!("-b{brick}"),
            Kind::Dense { naive: true, .. } => name += "-naive",
            Kind::Mesh { flat: true, .. } => name += "-flat",
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
            Kind::Field => return flags,
            Kind::Compiled => {
                add("--specialize");
                return flags;
            }
            Kind::MeshAsLarge => add("--via mesh"),
            Kind::Dense { mips, naive } => {
                add("--via dense");
                if mips {
                    add("--mips");
                }
                if naive && on_gpu {
                    add("--fill naive");
                }
            }
            Kind::Octree {
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
            Kind::Bricks { brick } => add(&format!("--via bricks --brick {brick}")),
            Kind::Mesh { dual, flat } => {
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
