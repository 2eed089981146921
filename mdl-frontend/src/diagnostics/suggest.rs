//! Finds the name that a misspelt one was meant to be.

/// The candidate nearest to `name`, if one is near enough to be a misspelling of it.
pub(crate) fn similar<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    // A third of the characters may differ; longer names than anyone mistypes are not compared.
    let limit = (name.chars().count() / 3).clamp(1, 4);
    if name.len() > 64 {
        return None;
    }
    candidates
        .into_iter()
        .filter(|candidate| candidate.len().abs_diff(name.len()) <= 4 && *candidate != name)
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|(distance, _)| *distance <= limit)
        .min()
        .map(|(_, candidate)| candidate.to_string())
}

/// Number of insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`; letters
/// that differ only in case count as equal (optimal string alignment distance).
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().map(|c| c.to_ascii_lowercase()).collect();
    let b: Vec<char> = b.chars().map(|c| c.to_ascii_lowercase()).collect();
    let mut rows = [vec![0; b.len() + 1], (0..=b.len()).collect(), vec![0; b.len() + 1]];
    for i in 1..=a.len() {
        let [two_before, before, row] = &mut rows;
        row[0] = i;
        for j in 1..=b.len() {
            let replaced = before[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replaced.min(before[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(two_before[j - 2] + 1);
            }
        }
        rows.rotate_left(1);
    }
    rows[1][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_candidate_is_suggested() {
        let names = ["roughness", "roughness_u", "tint"];
        assert_eq!(similar("roughnes", names).as_deref(), Some("roughness"));
        assert_eq!(similar("tnit", names).as_deref(), Some("tint"));
        assert_eq!(similar("Tint", names).as_deref(), Some("tint"));
        assert_eq!(similar("metal", names), None);
    }

    #[test]
    fn swap_of_neighbours_is_one_step() {
        assert_eq!(distance("ab", "ba"), 1);
        assert_eq!(distance("", "abc"), 3);
    }
}
