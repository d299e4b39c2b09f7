//! The tables of `itarl plot`, readable: short numbers, each with the file's own one behind it
//! (`<data value>`), which is what copying scripts and tests read.

use figures::{Measure, Results, Table, capitalised, three_digits};
use maud::{Markup, html};

/// The summary first; what has a row for each cell is folded.
pub(super) fn all(results: &Results) -> Markup {
    let measure = &results.measure;
    let mut tables = figures::tables(results);
    let place = |table: &Table| ABOUT.iter().position(|(name, ..)| *name == table.name);
    tables.sort_by_key(|table| place(table).unwrap_or(ABOUT.len()));
    html! {
        @for table in &tables {
            @match place(table).map(|place| ABOUT[place]) {
                Some((_, title, false)) => { h3 { (title(measure)) } (one(table, measure)) }
                Some((_, title, true)) => { details { summary { (title(measure)) } (one(table, measure)) } }
                None => { h3 { (table.name) } (one(table, measure)) }
            }
        }
        p .faint {
            (capitalised(&measure.symbol)) " in " (measure.unit) " for each control step; IQM is the interquartile mean "
            "over cells, with its 95 % bootstrap interval. Windows have " (results.windows()) " updates. "
            "The same tables are written by "
            code { "itarl plot" } " as CSV."
            @for caveat in figures::caveats(results) { " " (caveat) }
        }
    }
}

/// Tables in their order here: name, heading, whether it's folded.
const ABOUT: [About; 6] = [
    ("settings", |_| "Settings".into(), false),
    ("improvement", |_| "How probably one setting does better than another".into(), false),
    (
        "correlation",
        |measure| format!("Correlation of {} and {}", measure.symbol, information(measure)),
        false,
    ),
    ("instances", |_| "Every cell".into(), true),
    ("profile", |_| "How many reached how much".into(), true),
    ("efficiency", |_| "What was reached after how many steps".into(), true),
];

type About = (&'static str, fn(&Measure) -> String, bool);

fn one(table: &Table, measure: &Measure) -> Markup {
    let is_number = |text: &str| text.is_empty() || text.parse::<f64>().is_ok();
    let is_text = |column: usize| !table.rows.iter().all(|row| is_number(&row[column]));
    let columns: Vec<_> = (0..table.header.len()).map(is_text).collect();
    html! {
        div .scroll tabindex="0" role="region" aria-label=(table.name) {
            table id=(format!("table-{}", table.name)) {
                thead { tr { @for (name, text) in table.header.iter().zip(&columns) {
                    th scope="col" .text[*text] { (heading(name, measure)) }
                } } }
                tbody { @for row in &table.rows { tr { @for (value, text) in row.iter().zip(&columns) {
                    td .text[*text] { data value=(value) { (readable(value)) } }
                } } } }
            }
        }
    }
}

/// The symbol of the information.
fn information(measure: &Measure) -> &str {
    measure.information.as_ref().map_or("information", |it| &it.symbol)
}

/// `R_Loc_last_window_m` as "R_Loc last window [m]".
fn heading(name: &str, measure: &Measure) -> String {
    let Measure { symbol, unit, .. } = measure;
    let (name, unit) = match name.strip_suffix(&format!("_{unit}")) {
        Some(name) => (name, format!(" [{unit}]")),
        None => (name, String::new()),
    };
    let mut words = name.replace('_', " ");
    // Symbols keep their index.
    for symbol in [symbol, information(measure)] {
        words = words.replace(&symbol.replace('_', " "), symbol);
    }
    words + &unit
}

fn readable(value: &str) -> String {
    match (value, value.parse::<f64>()) {
        ("", _) => "\u{2013}".into(),
        ("true", _) => "yes".into(),
        ("false", _) => "no".into(),
        (_, Ok(number)) => short(number, value),
        (text, Err(_)) => text.into(),
    }
}

/// Whole numbers as they are, others with three significant digits.
fn short(number: f64, value: &str) -> String {
    if !value.contains(['.', 'e', 'E']) {
        return value.to_owned();
    }
    three_digits(number).replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use figures::Information;

    use super::*;

    #[test]
    fn numbers_are_short_and_whole_ones_whole() {
        for (value, text) in [
            ("12", "12"),
            ("0.0", "0"),
            ("0.0051234", "0.00512"),
            ("-1.2345", "\u{2212}1.23"),
            ("123456.7", "123457"),
            ("1.5e-7", "1.50e\u{2212}7"),
        ] {
            assert_eq!(short(value.parse().unwrap(), value), text);
        }
    }

    #[test]
    fn headings_have_units() {
        let walking = Measure::of_task("locomotion", "R_Loc", "m");
        assert_eq!(heading("R_Loc_last_window_m", &walking), "R_Loc last window [m]");
        assert_eq!(heading("share_collapsed", &walking), "share collapsed");
        let flow = Information::of_kind("transfer_entropy", "R_TE", ["nats", "link"]);
        let turning = Measure::of_task("turning", "turning", "rad").with(Some(flow), None);
        assert_eq!(heading("turning_mean_rad", &turning), "turning mean [rad]");
        assert_eq!(heading("pearson_turning_R_TE", &turning), "pearson turning R_TE");
    }

    #[test]
    fn what_files_hold_is_escaped() {
        let table = Table {
            name: "settings",
            header: vec!["setting".into()],
            rows: vec![vec!["</script><b x=\"1\">&".into()]],
        };
        let text = one(&table, &Measure::of_task("turning", "turning", "rad")).into_string();
        assert!(!text.contains("</script>") && !text.contains("<b"), "{text}");
        assert!(text.contains("&lt;/script&gt;&lt;b x=&quot;1&quot;&gt;&amp;"), "{text}");
    }
}
