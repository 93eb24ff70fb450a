//! What the trace keeps of the scene: materials, lights and cameras, as far as rays depend on them.

use crate::math::Vec3;

/// Most lights a trace can hold: each hit keeps two bits a light in one word.
pub const MAX_LIGHTS: usize = 16;

/// Kind of secondary rays that a surface spawns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bincode::Encode, bincode::Decode)]
pub enum Optics {
    /// None.
    Opaque,
    /// A reflection of constant weight.
    Mirror,
    /// A reflection weighted by Schlick's approximation.
    FresnelMirror,
    /// A reflection and a refraction weighted by the Fresnel equations.
    Dielectric,
}

/// A material, as far as rays and their weights depend on it.
#[derive(Clone, Debug, PartialEq, bincode::Encode, bincode::Decode)]
pub struct Material {
    /// Name in the scene.
    pub name: String,
    /// Kind of secondary rays.
    pub optics: Optics,
    /// Index of refraction of the inside against the outside.
    pub ior: f32,
    /// Weight of reflections, linear RGB.
    pub specular: Vec3,
    /// Tint of a refracted ray per surface crossed, linear RGB.
    pub transmission: Vec3,
    /// A cut-out texture decides where the surface is: rays may pass through its triangles.
    pub cutout: bool,
}

impl Material {
    /// True when a ray that meets a triangle of this material may go on as if it were not there, so that the recorded
    /// path of the triangle test has a third outcome. Shadow rays pass through dielectrics (tinted), all rays through
    /// the transparent texels of a cut-out.
    pub fn may_pass(&self, shadow_ray: bool) -> bool {
        self.cutout || (shadow_ray && self.optics == Optics::Dielectric)
    }
}

/// A light. Only its geometry enters rays; the colour is for the reader.
#[derive(Clone, Copy, Debug, PartialEq, bincode::Encode, bincode::Decode)]
pub enum Light {
    /// Shines from a point.
    Point {
        /// Position, scene units.
        position: Vec3,
        /// Linear RGB, intensity included.
        colour: Vec3,
    },
    /// Shines from infinity.
    Directional {
        /// Unit direction towards the light.
        to_light: Vec3,
        /// Linear RGB, intensity included.
        colour: Vec3,
    },
}

/// The camera of one frame as three vectors, so that no trigonometry stands between the trace and its rays.
///
/// The primary ray of sample `(x, y)` leaves `eye` in the direction `corner + right * (x + 0.5) + down * (y + 0.5)`.
#[derive(Clone, Copy, Debug, PartialEq, bincode::Encode, bincode::Decode)]
pub struct Camera {
    /// Ray origin.
    pub eye: Vec3,
    /// From the eye to the top left corner of the image plane.
    pub corner: Vec3,
    /// One sample to the right.
    pub right: Vec3,
    /// One sample down.
    pub down: Vec3,
}

/// What was captured, and how: the `META` chunk.
#[derive(Clone, Debug, PartialEq, bincode::Encode, bincode::Decode)]
pub struct Meta {
    /// Name and version of the program that wrote the trace.
    pub tool: String,
    /// Scene name.
    pub scene: String,
    /// BLAKE3 over everything in the scene that can change a ray or a colour.
    pub scene_hash: [u8; 32],
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Samples per pixel and axis: 1 to 8 in the format; captures take 1 or 2.
    pub samples: u32,
    /// Tile edge in samples.
    pub tile: u32,
    /// Number of the first captured frame of the camera path.
    pub first_frame: u32,
    /// Number of frames.
    pub frames: u32,
    /// Secondary bounces allowed: 0 is primary and shadow rays only.
    pub max_depth: u32,
    /// A child is spawned only if the largest component of its weight along the path from the eye exceeds this.
    pub min_weight: f32,
    /// The lights, at most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
}

impl Meta {
    /// Sample grid: columns and rows of samples in a frame.
    pub fn grid(&self) -> (u32, u32) {
        (self.width * self.samples, self.height * self.samples)
    }

    /// Tile grid: columns and rows of tiles in a frame.
    pub fn tile_grid(&self) -> (u32, u32) {
        let (w, h) = self.grid();
        (w.div_ceil(self.tile), h.div_ceil(self.tile))
    }

    /// Number of tiles in a frame. Tiles are numbered row by row from the top left.
    pub fn tile_count(&self) -> u32 {
        let (columns, rows) = self.tile_grid();
        columns * rows
    }

    /// The samples of tile `tile`.
    pub fn tile_rect(&self, tile: u32) -> Rect {
        let (w, h) = self.grid();
        let columns = self.tile_grid().0;
        let (x, y) = ((tile % columns) * self.tile, (tile / columns) * self.tile);
        Rect { x, y, width: self.tile.min(w - x), height: self.tile.min(h - y) }
    }

    /// Captured frame numbers, in order.
    pub fn frame_numbers(&self) -> std::ops::Range<u32> {
        self.first_frame..self.first_frame + self.frames
    }
}

/// A rectangle of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// Number of samples. They are numbered row by row.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// True for a rectangle without samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
