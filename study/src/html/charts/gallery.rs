//! All charts of a page, each with a name, as a reader can save it.

use std::cell::RefCell;

use crate::html::charts::chart::{Chart, link};
use crate::html::charts::file::{Saved, alone};
use crate::html::text::escape;

/// The charts of a page in the order in which they were drawn.
#[derive(Default)]
pub struct Gallery {
    saved: RefCell<Vec<Saved>>,
}

impl Gallery {
    /// A chart with its name above, a sentence that says how to read it, and what saves it. `words` name its files.
    pub fn card(&self, words: &[&str], title: &str, chart: &Chart, caption: &str) -> String {
        let (name, uri) = (self.keep(words, title, chart), link(&chart.data.csv()));
        let caption = if caption.is_empty() { String::new() } else { format!("<p>{}</p>", escape(caption)) };
        format!(
            "<figure class=\"card\" data-chart=\"{name}\"><figcaption><strong>{}</strong>{caption}</figcaption>{}\
             <p class=\"save\"><a download=\"{name}.csv\" href=\"{uri}\">CSV</a></p></figure>\n",
            escape(title),
            chart.svg,
        )
    }

    /// Keeps a chart as files alone; gives their name.
    pub fn keep(&self, words: &[&str], title: &str, chart: &Chart) -> String {
        let name = self.free(words);
        let (svg, csv) = (alone(chart, title), chart.data.csv());
        self.saved.borrow_mut().push(Saved { name: name.clone(), svg, csv });
        name
    }

    /// What was drawn.
    pub fn into_saved(self) -> Vec<Saved> {
        self.saved.into_inner()
    }

    /// A name for files that no chart has yet.
    fn free(&self, words: &[&str]) -> String {
        let name = words.iter().map(|word| plain(word)).filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-");
        let saved = self.saved.borrow();
        let taken = |name: &str| saved.iter().any(|other| other.name == name);
        let mut numbered = (1..).map(|i| if i == 1 { name.clone() } else { format!("{name}-{i}") });
        numbered.find(|name| !taken(name)).unwrap_or_default()
    }
}

/// Letters and digits of a text, whatever stands between them as one `_`: a name for any file system.
fn plain(text: &str) -> String {
    let parts = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("_").to_ascii_lowercase().chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::charts::chart::Data;

    #[test]
    fn names_are_of_letters_and_of_one_chart_each() {
        let gallery = Gallery::default();
        let chart = || Chart {
            svg: "<svg class=\"chart\" viewBox=\"0 0 1 2\"></svg>\n".into(),
            data: Data::new(&["x"]),
            keys: Vec::new(),
        };
        for words in [["energy", "../a b"], ["energy", "A/B"], ["energy", "\u{e9}"], ["energy", ""]] {
            gallery.card(&words, "t", &chart(), "");
        }
        let names: Vec<String> = gallery.into_saved().into_iter().map(|saved| saved.name).collect();
        assert_eq!(names, ["energy-a_b", "energy-a_b-2", "energy", "energy-2"]);
    }
}
