/// An image to measure: 8-bit sRGB, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rgb8Image {
    size: [u32; 2],
    rgb: Vec<u8>,
}

impl Rgb8Image {
    /// Creates an image from a size and three bytes per pixel. Returns `None` if the number of bytes does not
    /// match.
    pub fn new(size: [u32; 2], rgb: Vec<u8>) -> Option<Self> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        (rgb.len() as u64 == 3 * pixels).then_some(Self { size, rgb })
    }

    /// Creates an image from a color for each column and row.
    pub fn of([width, height]: [u32; 2], color: impl Fn(u32, u32) -> [u8; 3]) -> Self {
        let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self {
            size: [width, height],
            rgb: rows.flat_map(|(x, y)| color(x, y)).collect(),
        }
    }

    /// Returns width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the bytes of all pixels.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// Returns all pixels.
    pub fn pixels(&self) -> &[[u8; 3]] {
        self.rgb.as_chunks::<3>().0
    }
}
