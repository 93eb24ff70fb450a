//! Every value of the machine, with how well it is known and where it is from.

use crate::html::parts::{Head, Section, how_to_read, legend, table};
use crate::html::text::escape;
use crate::html::view::StudyView;
use crate::schema::ConfigValue;

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let values = &view.study.config;
    if values.is_empty() {
        return None;
    }
    let columns = [Head::words("Key"), Head::number("Value"), Head::words("Class"), Head::words("Source")];
    let row = |v: &ConfigValue| {
        let unit = if v.unit.is_empty() { String::new() } else { format!(" <small>{}</small>", escape(&v.unit)) };
        let class = format!("<span class=\"badge\">{}</span>", escape(&v.class));
        (
            String::new(),
            vec![format!("<code>{}</code>", escape(&v.key)), escape(&v.value) + &unit, class, escape(&v.source)],
        )
    };
    let rows: Vec<_> = values.iter().map(row).collect();
    let machine = view.study.machine.as_deref().unwrap_or("the machine");
    let html = format!(
        "<details id=\"config-values\"><summary>{} values of {}</summary>\n<div class=\"search\" hidden><label>Search \
         <input type=\"search\" id=\"config-search\" autocomplete=\"off\" placeholder=\"key, value, class or source\"></label> \
         <output id=\"config-found\"></output></div>\n{}</details>\n",
        values.len(),
        escape(machine),
        table(&format!("Configuration of {machine}"), &columns, &rows)
    );
    let read = "The class says how far a value can be trusted. paper: stated by the paper that is modelled; source: read in \
                another public source; memory: recalled from a publication that could not be read again; estimate: estimated, with \
                the derivation given; computed: computed from cited sources; choice: a modelling choice; anything else was set by \
                the user.";
    Section::new("config", "Configuration of the machine", counts(values) + &html + &how_to_read(read))
}

/// How many values are of each class.
fn counts(values: &[ConfigValue]) -> String {
    let mut classes: Vec<(&str, usize)> = Vec::new();
    for value in values {
        match classes.iter_mut().find(|(class, _)| *class == value.class) {
            Some((_, n)) => *n += 1,
            None => classes.push((&value.class, 1)),
        }
    }
    let item = |(class, n): &(&str, usize)| format!("<li><span class=\"badge\">{}</span> {n}</li>", escape(class));
    legend(&classes.iter().map(item).collect::<String>())
}
