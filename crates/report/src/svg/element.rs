//! What every chart is drawn with: figure, text, lines.

use crate::markup::escape;

/// Figures that are less wide are not blown up to the width of the others.
const NARROW: f64 = 240.0;

/// A figure with an accessible name; `caption` is shown under the drawing.
pub(super) fn figure(title: &str, width: f64, height: f64, caption: &str, body: &str) -> String {
    let class = if width < NARROW { " class=\"narrow\"" } else { "" };
    format!(
        "<figure{class}><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name}\"><title>{name}</title>\n{body}</svg>\
         <figcaption>{}</figcaption></figure>\n",
        escape(caption),
        name = escape(title),
    )
}

/// Text at a place; `class` chooses size and anchor.
pub(super) fn text(x: f64, y: f64, class: &str, content: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" class=\"{class}\">{}</text>\n", escape(content))
}

/// A straight line.
pub(super) fn line(from: (f64, f64), to: (f64, f64), class: &str) -> String {
    format!(
        "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" class=\"{class}\"/>\n",
        from.0, from.1, to.0, to.1
    )
}

/// A line through points; nothing for fewer than two.
pub(super) fn polyline(points: &[(f64, f64)], closed: bool, class: &str) -> String {
    if points.len() < 2 {
        return String::new();
    }
    let tag = if closed { "polygon" } else { "polyline" };
    let list: String = points.iter().map(|(x, y)| format!("{x:.1},{y:.1} ")).collect();
    format!("<{tag} points=\"{}\" class=\"{class}\"/>\n", list.trim_end())
}
