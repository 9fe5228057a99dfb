//! How the chunks of a recording are compressed.

/// Compression of the chunks of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChunkCompression {
    /// None: fastest, largest.
    #[default]
    None,
    /// LZ4: fast.
    Lz4,
    /// Zstandard: smallest.
    Zstd,
}

impl From<ChunkCompression> for Option<mcap::Compression> {
    fn from(compression: ChunkCompression) -> Self {
        match compression {
            ChunkCompression::None => None,
            ChunkCompression::Lz4 => Some(mcap::Compression::Lz4),
            ChunkCompression::Zstd => Some(mcap::Compression::Zstd),
        }
    }
}
