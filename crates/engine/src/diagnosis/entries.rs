//! Model entries of what was found. Every id is one of its own: neither in the model nor twice in the set.

use crate::diagnosis::scan::Scan;
use crate::diagnosis::view::{Item, What};
use trunnion_effects::{Formula, ModelEffect};

/// Entries of each item, in the order of the items. Of several expressions at one site the strongest has the plain name, the others
/// a number behind it.
pub fn entries(scan: &Scan<'_>, in_model: &[ModelEffect], items: &[Item]) -> Vec<Vec<ModelEffect>> {
    let mut taken: Vec<String> = in_model.iter().map(|entry| entry.id.clone()).collect();
    let mut strongest_first: Vec<usize> = (0..items.len()).collect();
    strongest_first.sort_by(|&a, &b| items[b].ln_odds.total_cmp(&items[a].ln_odds));
    let mut entries = vec![Vec::new(); items.len()];
    for i in strongest_first {
        entries[i] = of_item(scan, &items[i]);
        for entry in entries[i].iter_mut().filter(|entry| Formula::name_of(&entry.id).is_some()) {
            entry.id = free(&entry.id, &taken);
            taken.push(entry.id.clone());
        }
    }
    entries
}

fn of_item(scan: &Scan<'_>, item: &Item) -> Vec<ModelEffect> {
    match &item.what {
        What::Named(group) => vec![ModelEffect {
            id: scan.named[*group].instance.id(),
            shape: item.shape.clone(),
            ..ModelEffect::default()
        }],
        What::Open(term) => scan.vocabulary.entries(term, &item.shape),
    }
}

/// The id, or the id with the first number behind it that is free.
fn free(id: &str, taken: &[String]) -> String {
    let mut name = id.to_string();
    let mut number = 1;
    while taken.contains(&name) {
        number += 1;
        name = format!("{id}-{number}");
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_that_is_taken_gets_the_next_number() {
        let taken = ["formula:ball-dx", "formula:ball-dx-2"].map(String::from);
        assert_eq!(free("formula:ball-dx", &taken), "formula:ball-dx-3");
        assert_eq!(free("formula:ball-dy", &taken), "formula:ball-dy");
    }
}
