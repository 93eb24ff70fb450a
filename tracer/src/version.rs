//! What a capture says of the program that made it.

macro_rules! tracer_version {
    () => {
        "tracer 2"
    };
}

/// The version of the tracer. It grows by one whenever the same scene and settings may give other rays or paths than before: such captures
/// are not taken for one another, and are not gone on with.
///
/// (Within tracer 2, which no release had, colours of some models changed: of textures of odd sizes, of what is cut out, and of what stands
/// behind plain transparency.)
///
/// Tracer 1 padded boxes by 2^-18 of the distance to the far side of the scene, and built worse trees over flat scenes.
pub const TRACER_VERSION: &str = tracer_version!();

/// What a capture names as the program that made it.
pub const TOOL: &str = concat!("rayreel ", env!("CARGO_PKG_VERSION"), ", ", tracer_version!());
