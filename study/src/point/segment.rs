//! Rows as the bytes of a file.
//!
//! A segment is a line of JSON, then one line of JSON a row. The first line says what the rows belong to, counts them and holds the
//! CRC-32 of all that follows it, so a file that was torn, emptied or put there by somebody else is seen and ignored: its points are
//! computed again.

use serde::{Deserialize, Serialize};

use crate::error::{Result, StudyError};
use crate::point::row::Row;

/// Most bytes of a segment: some kilobytes for each of its rows.
pub(crate) const SEGMENT_MAX: u64 = 1 << 28;

/// Version of the layout of segments.
const LAYOUT: u32 = 1;

/// What the rows of a segment belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Belonging<'a> {
    /// Id of a plan; of rows without a plan, what takes its place.
    pub plan: &'a str,
    /// Bucket of the rows.
    pub bucket: usize,
}

/// The first line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Head {
    /// [`LAYOUT`].
    rayreel_segment: u32,
    /// [`Belonging::plan`].
    plan: String,
    /// [`Belonging::bucket`].
    bucket: usize,
    /// How many rows.
    rows: usize,
    /// CRC-32 of the rows.
    crc: u32,
    /// Who wrote them; not where equal rows must be equal bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    attempt: Option<String>,
    /// Where; likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    host: Option<String>,
}

/// Who writes segments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Writer {
    /// Name of the attempt; no two have the same.
    pub attempt: String,
    /// Name of the machine that it runs on.
    pub host: String,
}

/// The bytes of a segment; they say who wrote it if that is given.
///
/// # Errors
/// Never for rows of reports: their numbers are finite.
pub fn encode<'a>(
    belonging: Belonging<'_>,
    rows: impl IntoIterator<Item = &'a Row>,
    writer: Option<&Writer>,
) -> Result<Vec<u8>> {
    let (mut body, mut count) = (Vec::new(), 0);
    for row in rows {
        serde_json::to_writer(&mut body, row).map_err(StudyError::json)?;
        body.push(b'\n');
        count += 1;
    }
    let head = Head {
        rayreel_segment: LAYOUT,
        plan: belonging.plan.into(),
        bucket: belonging.bucket,
        rows: count,
        crc: crc32fast::hash(&body),
        attempt: writer.map(|w| w.attempt.clone()),
        host: writer.map(|w| w.host.clone()),
    };
    let mut bytes = serde_json::to_vec(&head).map_err(StudyError::json)?;
    bytes.push(b'\n');
    bytes.append(&mut body);
    Ok(bytes)
}

/// The rows of a segment, if it is whole and belongs there.
pub fn decode(bytes: &[u8], belonging: Belonging<'_>) -> Option<Vec<Row>> {
    let end = bytes.iter().position(|b| *b == b'\n')?;
    let (head, body) = (&bytes[..end], &bytes[end + 1..]);
    let head: Head = serde_json::from_slice(head).ok()?;
    let there = head.plan == belonging.plan && head.bucket == belonging.bucket;
    if head.rayreel_segment != LAYOUT || !there || head.crc != crc32fast::hash(body) {
        return None;
    }
    let rows: Option<Vec<Row>> =
        body.split_inclusive(|b| *b == b'\n').map(|line| serde_json::from_slice(line).ok()).collect();
    rows.filter(|rows| rows.len() == head.rows)
}
