//! Sets of tiles: `oak.<UDIM>.png` stands for all files with a number in that place.
//!
//! `<UDIM>` is 1001 + u + 10 v with u below 10; `<UVTILE0>` is `_u0_v0` and on, `<UVTILE1>` `_u1_v1` and on.

use mdl_jit::texture::MAX_TILES;
use std::path::{Path, PathBuf};

/// How tiles are numbered.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Numbering {
    Udim,
    /// By the first number of both axes.
    Uv(u32),
}

const MARKERS: [(&str, Numbering); 3] =
    [("<UDIM>", Numbering::Udim), ("<UVTILE0>", Numbering::Uv(0)), ("<UVTILE1>", Numbering::Uv(1))];

/// A tile of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Column and row.
    pub place: [u32; 2],
    /// Its file.
    pub file: PathBuf,
}

/// Whether the name of a file is one of a set of tiles.
pub fn is_set(path: &Path) -> bool {
    name(path).is_some_and(|name| MARKERS.iter().any(|(marker, _)| name.contains(marker)))
}

fn name(path: &Path) -> Option<&str> {
    path.file_name()?.to_str()
}

/// The files of a set by column and row. They lie in the folder of the set, not behind links that lead out
/// of it. An error if two are one tile.
pub fn tiles(set: &Path) -> Result<Vec<Tile>, String> {
    let (Some(pattern), Some(folder)) = (name(set), set.parent()) else { return Ok(Vec::new()) };
    let Some((marker, numbering)) = MARKERS.iter().find(|(marker, _)| pattern.contains(marker)) else {
        return Ok(Vec::new());
    };
    let (before, after) = pattern.split_once(marker).expect("it contains the marker");
    if MARKERS.iter().any(|(marker, _)| after.contains(marker)) {
        return Err("it has two markers of tiles".to_string());
    }
    let folder = folder.canonicalize().map_err(|e| e.to_string())?;
    let mut tiles: Vec<Tile> = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(|e| e.to_string())?.flatten() {
        let entry_name = entry.file_name();
        let number = entry_name.to_str().and_then(|n| n.strip_prefix(before)?.strip_suffix(after));
        let Some(place) = number.and_then(|number| place(*numbering, number)) else { continue };
        match entry.path().canonicalize() {
            Ok(file) if file.starts_with(&folder) && file.is_file() => tiles.push(Tile { place, file }),
            _ => {}
        }
    }
    tiles.sort_by_key(|tile| (tile.place[1], tile.place[0]));
    match tiles.windows(2).find(|pair| pair[0].place == pair[1].place) {
        None => Ok(tiles),
        Some(pair) => {
            Err(format!("`{}` and `{}` are the same tile", pair[0].file.display(), pair[1].file.display()))
        }
    }
}

/// Column and row that a number in a name means.
fn place(numbering: Numbering, number: &str) -> Option<[u32; 2]> {
    let count = |text: &str| match text.bytes().all(|b| b.is_ascii_digit()) && text.len() <= 5 {
        true => text.parse::<u32>().ok(),
        false => None,
    };
    let place = match numbering {
        Numbering::Udim => {
            let index = count(number).filter(|_| number.len() == 4)?.checked_sub(1001)?;
            [index % 10, index / 10]
        }
        Numbering::Uv(first) => {
            let (u, v) = number.strip_prefix("_u")?.split_once("_v")?;
            [count(u)?.checked_sub(first)?, count(v)?.checked_sub(first)?]
        }
    };
    place.iter().all(|&c| c < MAX_TILES).then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_places() {
        assert_eq!(place(Numbering::Udim, "1001"), Some([0, 0]));
        assert_eq!(place(Numbering::Udim, "1010"), Some([9, 0]));
        assert_eq!(place(Numbering::Udim, "1032"), Some([1, 3]));
        assert_eq!(place(Numbering::Uv(0), "_u2_v0"), Some([2, 0]));
        assert_eq!(place(Numbering::Uv(1), "_u1_v12"), Some([0, 11]));
        for (numbering, number) in [
            (Numbering::Udim, "1000"),
            (Numbering::Udim, "01001"),
            (Numbering::Udim, "+101"),
            (Numbering::Uv(0), "_u-1_v0"),
            (Numbering::Uv(1), "_u0_v1"),
            (Numbering::Uv(0), "_u1"),
            (Numbering::Uv(0), "_u9999_v0"),
        ] {
            assert_eq!(place(numbering, number), None, "{number}");
        }
        assert!(is_set(Path::new("a/b.<UDIM>.png")) && !is_set(Path::new("<UDIM>/b.png")));
    }
}
