//! `.npy`, `.nrrd` and `.raw`.

use super::lattice::{DenseValues, Lattice, Samples};
use argil_vdb::Voxel;
use glam::{IVec3, Vec3};

/// A type of stored numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum RawType {
    /// 32-bit floats.
    #[default]
    F32,
    /// 64-bit floats.
    F64,
    /// 16-bit floats.
    F16,
    /// Unsigned bytes.
    U8,
    /// Signed bytes.
    I8,
    /// Unsigned 16-bit integers.
    U16,
    /// Signed 16-bit integers.
    I16,
}

impl RawType {
    fn bytes(self) -> usize {
        match self {
            Self::F64 => 8,
            Self::F32 => 4,
            Self::F16 | Self::U16 | Self::I16 => 2,
            Self::U8 | Self::I8 => 1,
        }
    }

    fn of_nrrd(name: &str) -> Option<Self> {
        Some(match name {
            "float" => Self::F32,
            "double" => Self::F64,
            "uchar" | "unsigned char" | "uint8" | "uint8_t" => Self::U8,
            "signed char" | "int8" | "int8_t" => Self::I8,
            "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Self::U16,
            "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
                Self::I16
            }
            _ => return None,
        })
    }

    /// Reads numbers, little-endian or big-endian.
    fn numbers(self, bytes: &[u8], is_big: bool) -> Vec<f32> {
        let size = self.bytes();
        let number = |digits: &[u8]| {
            let mut word = [0; 8];
            for (i, byte) in digits.iter().enumerate() {
                word[if is_big { size - 1 - i } else { i }] = *byte;
            }
            let [a, b, c, d, ..] = word;
            match self {
                Self::F32 => f32::from_le_bytes([a, b, c, d]),
                Self::F64 => f64::from_le_bytes(word) as f32,
                Self::F16 => f32::read_half(&word),
                Self::U8 => f32::from(a),
                Self::I8 => f32::from(a as i8),
                Self::U16 => f32::from(u16::from_le_bytes([a, b])),
                Self::I16 => f32::from(i16::from_le_bytes([a, b])),
            }
        };
        bytes.chunks_exact(size).map(number).collect()
    }
}

/// The layout of a file without a header, or what its header does not say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RawLayout {
    /// `.raw`: numbers along x, y and z. x is fastest.
    pub shape: Option<[u32; 3]>,
    /// `.raw`: the type of numbers.
    pub number: RawType,
    /// Edge of a voxel. `None` makes the longest side 2 long.
    pub voxel_size: Option<f32>,
    /// Position of the first value. `None` centers the box.
    pub origin: Option<[f32; 3]>,
}

/// What a header says.
struct Header<'a> {
    shape: [usize; 3],
    /// Whether z is the fastest, and x the slowest. Else x is the fastest.
    is_z_fastest: bool,
    number: RawType,
    is_big: bool,
    voxel_size: Option<f32>,
    origin: Option<[f32; 3]>,
    values: &'a [u8],
}

/// Reads all values of a box.
pub(super) fn read_dense(
    bytes: &[u8],
    ending: &str,
    layout: &RawLayout,
) -> Result<Lattice, String> {
    let mut header = match ending {
        "npy" => npy(bytes)?,
        "nrrd" => nrrd(bytes)?,
        _ => raw(bytes, layout)?,
    };
    header.voxel_size = layout.voxel_size.or(header.voxel_size);
    header.origin = layout.origin.or(header.origin);
    let [nx, ny, nz] = header.shape;
    let count = nx
        .checked_mul(ny)
        .and_then(|n| n.checked_mul(nz))
        .unwrap_or(usize::MAX);
    let needed = count.saturating_mul(header.number.bytes());
    if header.values.len() < needed || count == 0 || nx.max(ny).max(nz) > 4096 {
        return Err(format!(
            "{nx} × {ny} × {nz} values take {needed} bytes, and the file has {}: it is truncated, or has none or more than 4096 values along a side",
            header.values.len()
        ));
    }
    let mut values = header
        .number
        .numbers(&header.values[..needed], header.is_big);
    if let Some(place) = values.iter().position(|value| !value.is_finite()) {
        return Err(format!(
            "value {place} is {}, not a number: replace it first",
            values[place]
        ));
    }
    if header.is_z_fastest {
        let at = |i: usize| (i / (nx * ny)) + nz * (i / nx % ny + ny * (i % nx));
        values = (0..values.len()).map(|i| values[at(i)]).collect();
    }
    let longest = nx.max(ny).max(nz).max(2) as f32 - 1.0;
    let voxel_size = header.voxel_size.unwrap_or(2.0 / longest);
    let size = IVec3::new(nx as i32, ny as i32, nz as i32);
    let centered = -0.5 * voxel_size * (size - 1).as_vec3();
    Ok(Lattice {
        voxel_size,
        origin: header.origin.map_or(centered, Vec3::from),
        samples: Samples::Dense(DenseValues {
            low: IVec3::ZERO,
            size,
            values,
            outside: None,
        }),
    })
}

fn raw<'a>(bytes: &'a [u8], layout: &RawLayout) -> Result<Header<'a>, String> {
    let text = "a .raw file does not say how many values it has: import it with --shape X,Y,Z, and with --type if they are no 32-bit floats";
    let shape = layout.shape.ok_or(text)?;
    Ok(Header {
        shape: shape.map(|n| n as usize),
        is_z_fastest: false,
        number: layout.number,
        is_big: false,
        voxel_size: None,
        origin: None,
        values: bytes,
    })
}

/// Reads a NumPy array (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>). Its axes are z, y, x. Which of
/// them is the fastest in the file does not matter.
fn npy(bytes: &[u8]) -> Result<Header<'_>, String> {
    const SHORT: &str = "the header of the array is truncated";
    let rest = bytes
        .strip_prefix(b"\x93NUMPY")
        .ok_or("not a NumPy array: its first bytes are those of another format")?;
    let (begin, length) = match rest.first().ok_or(SHORT)? {
        1 => {
            let count = rest.get(2..4).ok_or(SHORT)?;
            (4, usize::from(u16::from_le_bytes([count[0], count[1]])))
        }
        _ => {
            let length = rest.get(2..6).ok_or(SHORT)?;
            (
                6,
                u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize,
            )
        }
    };
    let text = rest
        .get(begin..)
        .and_then(|rest| rest.get(..length))
        .ok_or(SHORT)?;
    let values = &rest[begin + length..];
    let text = String::from_utf8_lossy(text).into_owned();
    let after = |key: &str| {
        let at = text
            .find(key)
            .ok_or_else(|| format!("the header of the array has no {key}"))?;
        Ok::<_, String>(text[at + key.len()..].trim_start_matches([':', ' ']))
    };
    let kind = after("'descr'")?;
    let kind = kind
        .trim_start_matches(['\'', '"'])
        .split(['\'', '"'])
        .next()
        .unwrap_or_default();
    let number = match kind.trim_start_matches(['<', '>', '|', '=']) {
        "f4" => RawType::F32,
        "f8" => RawType::F64,
        "f2" => RawType::F16,
        "u1" => RawType::U8,
        "i1" => RawType::I8,
        "u2" => RawType::U16,
        "i2" => RawType::I16,
        _ => {
            return Err(format!(
                "an array of the type {kind} is not supported: convert it to float32"
            ));
        }
    };
    let is_fortran = after("'fortran_order'")?.starts_with("True");
    let shape = after("'shape'")?;
    let shape = shape
        .trim_start_matches('(')
        .split(')')
        .next()
        .unwrap_or_default();
    let axes: Vec<usize> = shape
        .split(',')
        .filter_map(|n| n.trim().parse().ok())
        .collect();
    let [a, b, c] = axes[..] else {
        return Err(format!(
            "the array has the shape ({shape}): it must have three axes"
        ));
    };
    Ok(Header {
        shape: [c, b, a],
        is_z_fastest: is_fortran,
        number,
        is_big: kind.starts_with('>'),
        voxel_size: None,
        origin: None,
        values,
    })
}

/// Reads an NRRD file with its data (<https://teem.sourceforge.net/nrrd/format.html>).
fn nrrd(bytes: &[u8]) -> Result<Header<'_>, String> {
    if !bytes.starts_with(b"NRRD000") {
        return Err("not an NRRD file: its first bytes are those of another format".into());
    }
    // Lines end as those of either system.
    let end = (0..bytes.len().min(1 << 16)).find_map(|at| {
        let rest = &bytes[at..];
        let is_end = |mark: &[u8]| rest.starts_with(mark).then_some((at, at + mark.len()));
        is_end(b"\n\n").or_else(|| is_end(b"\r\n\r\n"))
    });
    let (end, begin) = end.ok_or("the header is truncated")?;
    let text = String::from_utf8_lossy(&bytes[..end]).to_lowercase();
    let field = |name: &str| {
        let mut lines = text.lines().filter_map(|line| line.split_once(':'));
        let found = lines.find(|(key, _)| key.trim() == name);
        found.map(|(_, value)| value.trim().to_owned())
    };
    let need = |name: &str| field(name).ok_or_else(|| format!("the header has no \"{name}\""));
    if field("data file").or(field("datafile")).is_some() {
        return Err(
            "the data lies in another file, which is not supported: save it as one .nrrd file"
                .into(),
        );
    }
    for name in ["byte skip", "byteskip", "line skip", "lineskip"] {
        if field(name).is_some_and(|skipped| skipped != "0") {
            return Err(format!(
                "\"{name}\" is not supported: save it again, without anything before the data"
            ));
        }
    }
    if need("encoding")? != "raw" {
        return Err(
            "the data is compressed, which is not supported: save it with the encoding raw".into(),
        );
    }
    let kind = need("type")?;
    let number = RawType::of_nrrd(&kind);
    let number =
        number.ok_or_else(|| format!("the type {kind} is not supported: convert it to float"))?;
    let sizes: Vec<usize> = need("sizes")?
        .split_whitespace()
        .filter_map(|n| n.parse().ok())
        .collect();
    let [x, y, z] = sizes[..] else {
        return Err(format!(
            "the file has {} axes: it must have three",
            sizes.len()
        ));
    };
    let numbers = |text: &str| -> Vec<f32> {
        let parts = text.split(['(', ')', ',', ' ']);
        parts.filter_map(|n| n.parse().ok()).collect()
    };
    let voxel_size = match (field("space directions"), field("spacings")) {
        (Some(text), _) => {
            let axes = numbers(&text);
            let [a, _, _, _, b, _, _, _, c] = axes[..] else {
                return Err("\"space directions\" must have three vectors".into());
            };
            let off: f32 = [1, 2, 3, 5, 6, 7].iter().map(|&i| axes[i].abs()).sum();
            Some(cube([a, b, c], off)?)
        }
        (None, Some(text)) => match numbers(&text)[..] {
            [a, b, c] if !(a.is_nan() && b.is_nan() && c.is_nan()) => Some(cube([a, b, c], 0.0)?),
            _ => None,
        },
        (None, None) => None,
    };
    let origin = field("space origin").or_else(|| field("axis mins"));
    let origin = origin.map(|text| numbers(&text));
    Ok(Header {
        shape: [x, y, z],
        is_z_fastest: false,
        number,
        is_big: field("endian").is_some_and(|value| value == "big"),
        voxel_size,
        origin: origin.and_then(|coordinates| <[f32; 3]>::try_from(coordinates).ok()),
        values: &bytes[begin..],
    })
}

/// Returns the edge of voxels that are cubes along the axes.
fn cube([a, b, c]: [f32; 3], off: f32) -> Result<f32, String> {
    let near = |length: f32| (length - a).abs() <= 1e-4 * a;
    if a > 0.0 && near(b) && near(c) && off <= 1e-4 * a {
        return Ok(a);
    }
    Err("the voxels are no cubes along the positive axes: resample it to uniform voxels, without rotation or mirroring".into())
}
