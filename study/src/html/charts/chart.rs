//! A chart that is drawn, and what it is drawn from.

use crate::html::text::escape;

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
    /// What it stands for.
    pub name: String,
}

impl Key {
    /// A key in the full colour.
    pub fn new(class: &str, name: &str) -> Self {
        Self { class: class.into(), opacity: 1.0, name: name.into() }
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

    /// As a file: a line of names, then the rows (RFC 4180).
    pub fn csv(&self) -> String {
        let line = |cells: &Vec<String>| cells.iter().map(|cell| field(cell)).collect::<Vec<_>>().join(",") + "\r\n";
        std::iter::once(&self.columns).chain(&self.rows).map(line).collect()
    }
}

/// A number of a chart: the shortest text that reads back the same; nothing where there is none.
pub fn cell(value: Option<f64>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// Text as a URI that a link can save.
pub fn link(text: &str) -> String {
    let mut uri = String::from("data:text/csv;charset=utf-8,");
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b",.-_:/()".contains(&byte) {
            uri.push(char::from(byte));
        } else {
            uri += &format!("%{byte:02X}");
        }
    }
    escape(&uri)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        let mut data = Data::new(&["a", "b, c"]);
        data.row(vec!["say \"x\"".into(), cell(Some(0.1))]);
        data.row(vec!["two\nlines".into(), cell(None)]);
        assert_eq!(data.csv(), "a,\"b, c\"\r\n\"say \"\"x\"\"\",0.1\r\n\"two\nlines\",\r\n");
        assert_eq!(link("a,b\r\n%&"), "data:text/csv;charset=utf-8,a,b%0D%0A%25%26");
    }
}
