//! A chart that is drawn, and what it is drawn from.

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

use crate::table::csv::plain_or_number;

/// A chart.
pub struct Chart {
    /// The picture, to stand in a page.
    pub svg: String,
    /// What it shows.
    pub data: Data,
    /// What its colours mean, for those who have no page around it.
    pub keys: Vec<Key>,
}

/// A colour of a chart, and what it stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Colour class.
    pub class: String,
    /// Shade of the colour, 0 to 1.
    pub opacity: f64,
    /// What has the colour.
    pub symbol: Symbol,
    /// What it stands for.
    pub name: String,
}

/// What has a colour in a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symbol {
    /// An area.
    Square,
    /// A line with a pattern of dashes.
    Line(&'static str),
    /// Nothing: the name says something of all of them.
    Word,
    /// A marker of a shape: more values than there are colours differ in it.
    Marker(usize),
}

impl Key {
    /// The key of an area in the full colour.
    pub fn new(class: &str, name: &str) -> Self {
        Self { class: class.into(), opacity: 1.0, symbol: Symbol::Square, name: name.into() }
    }

    /// The key of markers.
    pub fn of_marker(class: &str, shape: usize, name: &str) -> Self {
        Self { symbol: Symbol::Marker(shape), ..Self::new(class, name) }
    }

    /// Says how many are not among the keys.
    pub fn more(count: usize) -> Self {
        Self { symbol: Symbol::Word, ..Self::new("", &format!("and {count} more")) }
    }

    /// The key of a line: several lines may have one colour and differ in their dashes.
    pub fn of_line(class: &str, dash: &'static str, name: &str) -> Self {
        Self { symbol: Symbol::Line(dash), ..Self::new(class, name) }
    }
}

/// Each key once, in the order in which they first come.
pub fn once(keys: impl IntoIterator<Item = Key>) -> Vec<Key> {
    let mut found: Vec<Key> = Vec::new();
    for key in keys {
        if !found.contains(&key) {
            found.push(key);
        }
    }
    found
}

/// What a chart shows: a table.
pub struct Data {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Data {
    /// A table of these columns.
    pub fn new(columns: &[&str]) -> Self {
        Self { columns: columns.iter().map(|name| (*name).to_owned()).collect(), rows: Vec::new() }
    }

    /// One more row.
    pub fn row(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.columns.len());
        self.rows.push(cells);
    }

    /// As a file: a line of names, then the rows (RFC 4180). No word is a formula to a spreadsheet.
    pub fn csv(&self) -> String {
        let mut writer = csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(Vec::new());
        for cells in std::iter::once(&self.columns).chain(&self.rows) {
            let cells = cells.iter().map(|cell| plain_or_number(cell).into_owned());
            // All rows have as many cells as there are columns, and memory takes what it is given.
            writer.write_record(cells).unwrap_or_else(|e| unreachable!("{e}"));
        }
        let bytes = writer.into_inner().unwrap_or_else(|e| unreachable!("{e}"));
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

/// A number of a chart: the shortest text that reads back the same; nothing where there is none.
pub fn cell(value: Option<f64>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// A half interval, a part of its value, in percent: hundredths of a percent are enough.
pub fn in_percent(within: f64) -> f64 {
    (within * 1e4).round() / 1e2
}

/// The same as a number of a chart.
pub fn percent_cell(within: Option<f64>) -> String {
    cell(within.map(in_percent))
}

/// Both ends of the interval of a value, to be drawn. One that is wider than the value would go beyond zero: only its column tells of it.
pub fn ends(value: f64, within: Option<f64>) -> [f64; 2] {
    let part = within.filter(|part| (0.0..=1.0).contains(part)).unwrap_or(0.0);
    [value * (1.0 - part), (value * (1.0 + part)).clamp(f64::MIN, f64::MAX)]
}

/// What stands in a data URI as it is.
const PLAIN: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b',').remove(b'.').remove(b'-').remove(b'_').remove(b':').remove(b'/');

/// Text as a URI that a link can save.
pub fn link(text: &str) -> String {
    format!("data:text/csv;charset=utf-8,{}", utf8_percent_encode(text, PLAIN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_mean_nothing_are_not_drawn() {
        assert_eq!(ends(4.0, Some(0.25)), [3.0, 5.0]);
        for within in [None, Some(f64::NAN), Some(f64::INFINITY), Some(-0.5), Some(1.5)] {
            assert_eq!(ends(4.0, within), [4.0, 4.0], "{within:?}");
        }
        assert_eq!(ends(f64::MAX, Some(1.0)), [0.0, f64::MAX]);
        assert_eq!([percent_cell(Some(0.066_07)), percent_cell(None)], ["6.61", ""]);
    }

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        let mut data = Data::new(&["a", "b, c"]);
        data.row(vec!["say \"x\"".into(), cell(Some(0.1))]);
        data.row(vec!["two\nlines".into(), cell(None)]);
        assert_eq!(data.csv(), "a,\"b, c\"\r\n\"say \"\"x\"\"\",0.1\r\n\"two\nlines\",\r\n");
        let mut data = Data::new(&["=name", "number"]);
        data.row(vec!["@sum".into(), cell(Some(-0.5))]);
        data.row(vec!["-1+1".into(), cell(Some(f64::NEG_INFINITY))]);
        assert_eq!(data.csv(), "'=name,number\r\n'@sum,-0.5\r\n'-1+1,-inf\r\n");
        assert_eq!(link("a,b\r\n%&"), "data:text/csv;charset=utf-8,a,b%0D%0A%25%26");
    }
}
