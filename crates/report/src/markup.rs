//! Markup that is well-formed as XML and harmless whatever the names say.

/// Text with the five reserved characters escaped and control characters replaced.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\n' | '\t' => safe.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// `<tag>escaped text</tag>`.
pub fn element(tag: &str, text: &str) -> String {
    format!("<{tag}>{}</{tag}>", escape(text))
}

/// A table that scrolls sideways on a narrow screen; cells are text, `numeric` columns are aligned right.
pub fn table(caption: &str, head: &[&str], numeric: &[usize], rows: &[Vec<String>]) -> String {
    let class = |i: usize| if numeric.contains(&i) { " class=\"n\"" } else { "" };
    let head: String = head
        .iter()
        .enumerate()
        .map(|(i, h)| format!("<th scope=\"col\"{}>{}</th>", class(i), escape(h)))
        .collect();
    let body: String = rows
        .iter()
        .map(|row| {
            let cells =
                row.iter().enumerate().map(|(i, cell)| format!("<td{}>{}</td>", class(i), escape(cell)));
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        })
        .collect();
    let table = format!(
        "<table><caption>{}</caption><thead><tr>{head}</tr></thead><tbody>\n{body}</tbody></table>",
        escape(caption)
    );
    scrolling(caption, &table) + "\n"
}

/// Markup that scrolls sideways on a narrow screen, also by keyboard: what takes the focus has a name.
pub fn scrolling(name: &str, markup: &str) -> String {
    let name = escape(name);
    format!("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{name}\">{markup}</div>")
}
