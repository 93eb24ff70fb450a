//! Tables as files. A batch is encoded where it was made, in any thread ([`Encoder`]); a [`Sink`] puts what came of it one behind the
//! other. The bytes depend on the batches alone.

#[cfg(feature = "csv")]
mod csv;
#[cfg(feature = "jsonl")]
mod jsonl;
mod npy;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(any(feature = "csv", feature = "jsonl"))]
mod text;

use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use rayreel_formats::durable::WholeFile;

use crate::error::{ColumnsError, Result};
use crate::schema::{Batch, Head};

#[cfg(feature = "parquet")]
pub use parquet::KEY;

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Apache Parquet.
    #[cfg(feature = "parquet")]
    Parquet,
    /// An array of records of NumPy.
    Npy,
    /// Comma-separated values.
    #[cfg(feature = "csv")]
    Csv,
    /// An object of JSON a line.
    #[cfg(feature = "jsonl")]
    Jsonl,
}

impl Format {
    /// All that this build knows.
    pub const ALL: &'static [Self] = &[
        #[cfg(feature = "parquet")]
        Self::Parquet,
        Self::Npy,
        #[cfg(feature = "csv")]
        Self::Csv,
        #[cfg(feature = "jsonl")]
        Self::Jsonl,
    ];

    /// The name, which is also how names of such files end.
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(feature = "parquet")]
            Self::Parquet => "parquet",
            Self::Npy => "npy",
            #[cfg(feature = "csv")]
            Self::Csv => "csv",
            #[cfg(feature = "jsonl")]
            Self::Jsonl => "jsonl",
        }
    }

    /// The format of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| format.name() == name)
    }

    /// The format that the name of a file asks for, in letters of either case.
    pub fn of(path: &Path) -> Option<Self> {
        Self::named(&path.extension()?.to_str()?.to_ascii_lowercase())
    }

    /// Whether it is read from the beginning to the end, so that it can be piped.
    pub fn is_text(self) -> bool {
        match self {
            #[cfg(feature = "parquet")]
            Self::Parquet => false,
            Self::Npy => false,
            #[cfg(feature = "csv")]
            Self::Csv => true,
            #[cfg(feature = "jsonl")]
            Self::Jsonl => true,
        }
    }
}

/// Encodes batches of a table.
#[derive(Debug)]
pub struct Encoder {
    format: Format,
    head: Head,
    #[cfg(feature = "parquet")]
    layout: Option<parquet::Layout>,
}

/// An encoded batch.
#[derive(Debug)]
pub struct Encoded {
    rows: u64,
    body: Body,
}

#[derive(Debug)]
enum Body {
    Bytes(Vec<u8>),
    #[cfg(feature = "parquet")]
    Group(Vec<parquet::Chunk>),
}

impl Encoded {
    /// How many rows.
    pub fn rows(&self) -> u64 {
        self.rows
    }
}

impl Encoder {
    /// For the columns of `head`.
    ///
    /// # Errors
    /// Never for a table of ours.
    pub fn new(format: Format, head: Head) -> Result<Self> {
        Self::of(format, head, None)
    }

    /// The same with `origin`, a JSON object that says what made the table: Parquet has a place for it.
    ///
    /// # Errors
    /// As there.
    #[cfg_attr(not(feature = "parquet"), expect(unused_variables, reason = "other formats have no place for it"))]
    pub fn of(format: Format, head: Head, origin: Option<&str>) -> Result<Self> {
        #[cfg(feature = "parquet")]
        let layout = if format == Format::Parquet { Some(parquet::Layout::new(&head, origin)?) } else { None };
        Ok(Self {
            format,
            head,
            #[cfg(feature = "parquet")]
            layout,
        })
    }

    /// Encodes a batch of all columns of the table; those that are not wanted are left out.
    ///
    /// # Errors
    /// Never for a batch of the table.
    pub fn encode(&self, batch: Batch) -> Result<Encoded> {
        let batch = batch.select(&self.head.places);
        let rows = batch.rows() as u64;
        let body = match self.format {
            #[cfg(feature = "parquet")]
            Format::Parquet => Body::Group(self.layout.as_ref().map_or(Ok(Vec::new()), |to| to.encode(&batch))?),
            Format::Npy => Body::Bytes(npy::rows(&self.head, &batch)),
            #[cfg(feature = "csv")]
            Format::Csv => Body::Bytes(csv::rows(&batch)?),
            #[cfg(feature = "jsonl")]
            Format::Jsonl => Body::Bytes(jsonl::rows(&self.head, &batch)?),
        };
        Ok(Encoded { rows, body })
    }

    /// What a file begins with; again at its end, where the number of rows stands in it.
    fn beginning(&self, rows: u64) -> Result<Vec<u8>> {
        match self.format {
            Format::Npy => npy::header(&self.head, rows),
            #[cfg(feature = "csv")]
            Format::Csv => csv::header(&self.head),
            #[cfg(any(feature = "parquet", feature = "jsonl"))]
            _ => Ok(Vec::new()),
        }
    }
}

/// Where bytes go.
enum Target {
    File(WholeFile),
    Stream(Box<dyn Write + Send>),
}

impl Write for Target {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.write(bytes),
            Self::Stream(stream) => stream.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::File(file) => file.flush(),
            Self::Stream(stream) => stream.flush(),
        }
    }
}

/// A file that is being written: whole or absent. What goes to a stream is there at once.
pub struct Sink<'a> {
    encoder: &'a Encoder,
    name: PathBuf,
    rows: u64,
    to: To,
}

enum To {
    Plain(Target),
    #[cfg(feature = "parquet")]
    Parquet(Box<parquet::File<Target>>),
}

impl<'a> Sink<'a> {
    /// Begins to write a file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn file(encoder: &'a Encoder, path: &Path) -> Result<Self> {
        let file = WholeFile::create(path).map_err(|source| ColumnsError::output(path, source))?;
        Self::begin(encoder, path, Target::File(file))
    }

    /// Begins to write to a stream, which `name` names in messages.
    ///
    /// # Errors
    /// [`ColumnsError::Request`] for a format that is no text; when the stream takes nothing.
    pub fn stream(encoder: &'a Encoder, name: &str, to: Box<dyn Write + Send>) -> Result<Self> {
        if !encoder.format.is_text() {
            let format = encoder.format.name();
            return Err(ColumnsError::Request(format!(
                "{format} cannot be piped: its readers look back and forth; name a file, or take csv or jsonl"
            )));
        }
        Self::begin(encoder, Path::new(name), Target::Stream(to))
    }

    fn begin(encoder: &'a Encoder, name: &Path, target: Target) -> Result<Self> {
        let name = name.to_path_buf();
        #[cfg(feature = "parquet")]
        if let Some(layout) = &encoder.layout {
            let file = parquet::File::begin(layout, target).map_err(|error| parquet::refused(&name, error))?;
            return Ok(Self { encoder, name, rows: 0, to: To::Parquet(Box::new(file)) });
        }
        let mut sink = Self { encoder, name, rows: 0, to: To::Plain(target) };
        sink.write(&encoder.beginning(0)?)?;
        Ok(sink)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        match &mut self.to {
            To::Plain(target) => target.write_all(bytes).map_err(|source| ColumnsError::output(&self.name, source)),
            #[cfg(feature = "parquet")]
            To::Parquet(_) => Ok(()),
        }
    }

    /// Appends a batch.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn append(&mut self, encoded: Encoded) -> Result<()> {
        self.rows += encoded.rows;
        match (encoded.body, &mut self.to) {
            (Body::Bytes(bytes), _) => self.write(&bytes),
            #[cfg(feature = "parquet")]
            (Body::Group(group), To::Parquet(file)) => {
                if encoded.rows > 0 {
                    file.append(group).map_err(|error| parquet::refused(&self.name, error))
                } else {
                    Ok(())
                }
            }
            #[cfg(feature = "parquet")]
            (Body::Group(_), To::Plain(_)) => Ok(()),
        }
    }

    /// Ends the file: only now it has its name. Gives the number of rows.
    ///
    /// # Errors
    /// When it cannot be written.
    #[cfg_attr(
        not(feature = "parquet"),
        allow(clippy::infallible_destructuring_match, reason = "there is one kind of file then")
    )]
    pub fn finish(self) -> Result<u64> {
        let Self { encoder, name, rows, to } = self;
        let mut target = match to {
            To::Plain(target) => target,
            #[cfg(feature = "parquet")]
            To::Parquet(file) => file.finish().map_err(|error| parquet::refused(&name, error))?,
        };
        let end = |target: &mut Target| {
            if let (Target::File(file), Format::Npy) = (&mut *target, encoder.format) {
                file.seek(SeekFrom::Start(0))?;
                file.write_all(&encoder.beginning(rows).map_err(io::Error::other)?)?;
            }
            target.flush()
        };
        let ended = end(&mut target).and_then(|()| match target {
            Target::File(file) => file.finish(),
            Target::Stream(_) => Ok(()),
        });
        ended.map_err(|source| ColumnsError::output(&name, source)).map(|()| rows)
    }
}
