//! How the chunks of a recording are compressed, and how much of them is unpacked.

/// How many bytes a byte of a file may unpack to: as many as LZ4 can reach. Zstandard reaches thousands, but only with chunks
/// that were made to keep their reader busy.
const MAX_RATIO: u64 = 255;

/// What a file of any length may unpack to \[bytes\]: small recordings of equal messages pack well.
const FREE: u64 = 512 << 20;

/// How much of a file was unpacked, with a bound, so that reading takes a time in proportion to the length of the file.
#[derive(Debug, Default)]
pub(crate) struct Unpacked {
    bytes: u64,
}

impl Unpacked {
    /// Counts a chunk that ends at this byte of the file and states the length of its records; an error if that is too much.
    pub fn add(&mut self, chunk_end: u64, stated: u64) -> Result<(), String> {
        let bytes = self.bytes.saturating_add(stated);
        let most = chunk_end.saturating_mul(MAX_RATIO).saturating_add(FREE);
        if bytes > most {
            return Err(format!(
                "expected chunks that unpack to at most {MAX_RATIO} times their length and {} MiB, found {} MiB in the first {chunk_end} \
                 bytes of the file",
                FREE >> 20,
                bytes >> 20
            ));
        }
        self.bytes = bytes;
        Ok(())
    }
}

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
