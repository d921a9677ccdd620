/// A picture to be measured: 8 bits of red, green and blue a pixel, in sRGB, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    size: [u32; 2],
    rgb: Vec<u8>,
}

impl Picture {
    /// Of a width and a height and three bytes for each pixel; nothing where there are not as many.
    pub fn new(size: [u32; 2], rgb: Vec<u8>) -> Option<Self> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        (rgb.len() as u64 == 3 * pixels).then_some(Self { size, rgb })
    }

    /// Of a color for each pixel, by its column and row.
    pub fn of([width, height]: [u32; 2], color: impl Fn(u32, u32) -> [u8; 3]) -> Self {
        let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self {
            size: [width, height],
            rgb: rows.flat_map(|(x, y)| color(x, y)).collect(),
        }
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The bytes of all pixels.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// All pixels.
    pub fn pixels(&self) -> &[[u8; 3]] {
        self.rgb.as_chunks::<3>().0
    }
}
