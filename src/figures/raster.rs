//! Renders SVG as PNG.

use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Pixels per displayed unit of the SVG.
const SCALE: f32 = 5.0 / 3.0;

/// Renders SVG with the embedded font only.
pub(super) struct Raster {
    options: Options<'static>,
}

impl Raster {
    pub fn new() -> Self {
        let mut options = Options::default();
        let fonts = options.fontdb_mut();
        for font in [dejavu::sans::regular(), dejavu::sans::bold()] {
            fonts.load_font_source(resvg::usvg::fontdb::Source::Binary(Arc::new(font)));
        }
        Self { options }
    }

    /// The picture as PNG; the error is the message of the library.
    pub fn png(&self, svg: &str) -> Result<Vec<u8>, String> {
        let tree = self.tree(svg)?;
        let size = tree
            .size()
            .to_int_size()
            .scale_by(SCALE)
            .ok_or("the picture has no size")?;
        let mut picture =
            Pixmap::new(size.width(), size.height()).ok_or("the picture is too large")?;
        resvg::render(
            &tree,
            Transform::from_scale(SCALE, SCALE),
            &mut picture.as_mut(),
        );
        picture.encode_png().map_err(|fault| fault.to_string())
    }

    /// The SVG with its text laid out.
    pub fn tree(&self, svg: &str) -> Result<Tree, String> {
        Tree::from_str(svg, &self.options).map_err(|fault| fault.to_string())
    }
}
