//! The column directory at the start of a `TILE` payload: lets one column be read and checked without the others.

use super::wire::{Fields, push_crc, split_crc};
use crate::error::{Checked, Error, Fault, Place, Result, check_limit};
use crate::limits::Limits;

/// Bytes of a directory without columns.
const DIRECTORY_FIXED_LEN: usize = 8;
/// Bytes per column in a directory.
const DIRECTORY_COLUMN_LEN: usize = 24;

/// Bytes of the longest directory that the format can hold.
pub(crate) const DIRECTORY_LEN_MAX: u64 = (DIRECTORY_FIXED_LEN + u8::MAX as usize * DIRECTORY_COLUMN_LEN) as u64;

/// One column to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnEntry {
    /// Which column; unique within a tile.
    pub id: u8,
    /// How its bytes are coded; the container does not look into it.
    pub codec: u8,
    /// Bytes after decoding.
    pub raw_len: u64,
    /// The coded bytes.
    pub packed: Vec<u8>,
}

/// One column of a tile in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColumnInfo {
    /// Which column.
    pub id: u8,
    /// How its bytes are coded.
    pub codec: u8,
    /// Bytes after decoding. Checked against [`Limits::max_chunk_raw_bytes`], but not against the coded bytes.
    pub raw_len: u64,
    /// Bytes in the file.
    pub packed_len: u64,
    /// Offset of the coded bytes from the start of the tile's payload.
    pub offset: u64,
    /// CRC-32 of the coded bytes.
    pub crc: u32,
}

/// The columns of a tile, ascending by id, each once, without gaps in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileDirectory {
    columns: Vec<ColumnInfo>,
}

impl TileDirectory {
    /// All columns, ascending by id.
    pub fn columns(&self) -> &[ColumnInfo] {
        &self.columns
    }

    /// The column with this id.
    pub fn column(&self, id: u8) -> Option<&ColumnInfo> {
        let at = self.columns.binary_search_by_key(&id, |column| column.id).ok()?;
        self.columns.get(at)
    }

    /// Bytes that this directory takes in the file.
    pub(crate) fn file_len(&self) -> u32 {
        (DIRECTORY_FIXED_LEN + self.columns.len() * DIRECTORY_COLUMN_LEN) as u32
    }

    /// Bytes that the directory of a tile with this many columns takes in the file.
    pub(crate) fn encoded_len(columns: u8) -> u32 {
        (DIRECTORY_FIXED_LEN + usize::from(columns) * DIRECTORY_COLUMN_LEN) as u32
    }

    /// Reads the directory at the start of `bytes`, of a payload of `payload_len` bytes in the file.
    ///
    /// # Errors
    /// [`Error::Damaged`] and [`Error::LimitExceeded`], at `place`.
    pub fn parse(bytes: &[u8], payload_len: u64, place: &Place, limits: &Limits) -> Result<Self> {
        let truncated =
            |needed: u64| Error::damaged(place.clone(), Fault::Truncated { needed, available: bytes.len() as u64 });
        let &count = bytes.first().ok_or_else(|| truncated(DIRECTORY_FIXED_LEN as u64))?;
        check_limit("number of columns", u64::from(count), u64::from(limits.max_columns_per_tile))
            .map_err(|error| error.at(place))?;
        let len = Self::encoded_len(count);
        let body = match bytes.get(..len as usize).and_then(split_crc) {
            None => return Err(truncated(u64::from(len))),
            Some(Err(bad)) => {
                let (part, stored, computed) = (Checked::Directory, bad.stored, bad.computed);
                return Err(Error::damaged(place.clone(), Fault::Checksum { part, stored, computed }));
            }
            Some(Ok(body)) => body,
        };
        let columns = parse_columns(body, u64::from(len), place, limits)?;
        let end = columns.last().map_or(u64::from(len), |last| last.offset + last.packed_len);
        if end != payload_len {
            let detail = format!("the columns end at byte {end} of a payload of {payload_len}");
            return Err(Error::corrupt(place.clone(), detail));
        }
        Ok(Self { columns })
    }
}

/// The column entries of a directory whose checksum holds; their bytes start `offset` bytes into the payload.
fn parse_columns(body: &[u8], mut offset: u64, place: &Place, limits: &Limits) -> Result<Vec<ColumnInfo>> {
    let corrupt = |detail: &str| Error::corrupt(place.clone(), detail);
    let mut columns: Vec<ColumnInfo> = Vec::new();
    let mut fields = Fields(body);
    let _count = fields.bytes::<4>();
    while !fields.0.is_empty() {
        let column = parse_column(&mut fields, offset).ok_or_else(|| corrupt("a column entry is cut short"))?;
        if columns.last().is_some_and(|last| last.id >= column.id) {
            return Err(corrupt("column ids do not ascend"));
        }
        check_limit("packed length of a column in bytes", column.packed_len, limits.max_chunk_packed_bytes)
            .and_then(|()| check_limit("raw length of a column in bytes", column.raw_len, limits.max_chunk_raw_bytes))
            .map_err(|error| error.at(place))?;
        offset = offset.checked_add(column.packed_len).ok_or_else(|| corrupt("column lengths overflow"))?;
        columns.push(column);
    }
    Ok(columns)
}

fn parse_column(fields: &mut Fields<'_>, offset: u64) -> Option<ColumnInfo> {
    let (id, codec, _reserved, crc) = (fields.u8()?, fields.u8()?, fields.u16()?, fields.u32()?);
    Some(ColumnInfo { id, codec, crc, packed_len: fields.u64()?, raw_len: fields.u64()?, offset })
}

/// The payload of a tile with these columns, and the length of its directory. The order given does not matter.
///
/// # Errors
/// [`Error::Usage`] if two columns have the same id.
pub(crate) fn encode_tile(columns: &[ColumnEntry]) -> Result<(Vec<u8>, u32)> {
    let mut sorted: Vec<&ColumnEntry> = columns.iter().collect();
    sorted.sort_by_key(|column| column.id);
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0].id == pair[1].id) {
        return Err(Error::usage(format!("two columns of a tile have the id {}", pair[0].id)));
    }
    let count = u8::try_from(sorted.len()).map_err(|_| Error::usage("a tile holds at most 255 columns"))?;
    let directory_len = TileDirectory::encoded_len(count);
    let packed: usize = sorted.iter().map(|column| column.packed.len()).sum();
    let mut payload = Vec::with_capacity(directory_len as usize + packed);
    payload.extend_from_slice(&[count, 0, 0, 0]);
    for column in &sorted {
        payload.extend_from_slice(&[column.id, column.codec, 0, 0]);
        payload.extend_from_slice(&crc32fast::hash(&column.packed).to_le_bytes());
        payload.extend_from_slice(&(column.packed.len() as u64).to_le_bytes());
        payload.extend_from_slice(&column.raw_len.to_le_bytes());
    }
    push_crc(&mut payload);
    for column in &sorted {
        payload.extend_from_slice(&column.packed);
    }
    Ok((payload, directory_len))
}
