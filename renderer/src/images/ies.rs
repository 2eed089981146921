//! Measured lamps: photometric files after ANSI/IES LM-63 (versions 1986 to 2019).
//!
//! Type C has vertical angles from 0° (downwards, the z axis here) and horizontal angles around that axis
//! from x; given are a part of them and symmetry. Types A and B look along z: A has its pole along y (V is
//! the elevation, H turns around y), B along x (H is the elevation, V turns around x). Behind what was
//! measured there is no light. Factors for a tilt of the lamp are read and not used.
//!
//! Everything is bounded: sizes by the file, numbers by being finite, angles by ascending.

use super::load::{ImageError, ImageFile, ImageLimits, read_with};
use super::profile::Profile;

/// Most bytes of a file.
const MAX_BYTES: u64 = 16 << 20;
/// Most angles along an axis.
const MAX_ANGLES: usize = 4096;

/// Reads a light profile.
pub fn load_profile<'a>(file: impl Into<ImageFile<'a>>) -> Result<Profile, ImageError> {
    let limits = ImageLimits { bytes: MAX_BYTES, ..ImageLimits::default() };
    read_with(file.into(), &limits, |bytes| parse(&String::from_utf8_lossy(bytes)))
}

/// Photometric type.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    A,
    B,
    C,
}

/// Intensities by angle, as a file has them.
#[derive(Debug)]
struct Grid {
    kind: Kind,
    vertical: Vec<f64>,
    horizontal: Vec<f64>,
    /// In candela, by horizontal, then by vertical angle.
    candela: Vec<f64>,
}

/// Numbers in order.
struct Numbers<'a> {
    rest: Box<dyn Iterator<Item = &'a str> + 'a>,
}

impl Numbers<'_> {
    fn next(&mut self, what: &str) -> Result<f64, String> {
        let text = self.rest.next().ok_or_else(|| format!("it ends where {what} is expected"))?;
        match text.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(format!("`{text}` stands where {what} is expected")),
        }
    }

    fn count(&mut self, what: &str) -> Result<usize, String> {
        let x = self.next(what)?;
        match x.fract() == 0.0 && (1.0..=MAX_ANGLES as f64).contains(&x) {
            true => Ok(x as usize),
            false => Err(format!("{what} is {x}; 1 to {MAX_ANGLES} are read")),
        }
    }

    fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>, String> {
        (0..count).map(|_| self.next(what)).collect()
    }

    fn angles(&mut self, count: usize, what: &str) -> Result<Vec<f64>, String> {
        let angles = self.list(count, what)?;
        match angles.windows(2).find(|pair| pair[0] >= pair[1]) {
            None => Ok(angles),
            Some(pair) => Err(format!("{what} do not ascend: {} stands after {}", pair[1], pair[0])),
        }
    }
}

/// Reads the text of a file.
pub(super) fn parse(text: &str) -> Result<Profile, String> {
    let tilt = text.lines().position(|line| line.trim_start().starts_with("TILT="));
    let tilt = tilt.ok_or("it has no line TILT=, so it is no photometric file")?;
    let mut lines = text.lines().skip(tilt);
    let kind_of_tilt = lines.next().unwrap_or_default().trim_start().trim_start_matches("TILT=").trim();
    let separators = |c: char| c.is_whitespace() || c == ',';
    let words = lines.flat_map(move |line| line.split(separators)).filter(|word| !word.is_empty());
    let mut numbers = Numbers { rest: Box::new(words) };
    match kind_of_tilt {
        "NONE" => {}
        "INCLUDE" => {
            numbers.next("the geometry of the lamp")?;
            let count = numbers.count("the number of tilts")?;
            numbers.list(2 * count, "an angle or factor of tilt")?;
        }
        file => return Err(format!("its tilt is in another file, `{file}`, which is not supported")),
    }
    let grid = grid(&mut numbers)?;
    let lit = match grid.kind {
        Kind::C => [grid.vertical[0], grid.vertical[grid.vertical.len() - 1]],
        _ => [0.0, 90.0],
    };
    Ok(Profile::new(grid.step(), grid.is_axial(), lit, |theta, phi| grid.candela(theta, phi)))
}

fn grid(numbers: &mut Numbers<'_>) -> Result<Grid, String> {
    numbers.next("the number of lamps")?;
    numbers.next("the lumens of a lamp")?;
    let mut factor = numbers.next("the factor of intensities")?;
    let vertical = numbers.count("the number of vertical angles")?;
    let horizontal = numbers.count("the number of horizontal angles")?;
    let kind = match numbers.next("the photometric type")? {
        1.0 => Kind::C,
        2.0 => Kind::B,
        3.0 => Kind::A,
        other => return Err(format!("its photometric type is {other}; 1, 2 and 3 are read")),
    };
    numbers.list(4, "the unit or a side of the lamp")?;
    factor *= numbers.next("the ballast factor")?;
    // What older versions call the photometric factor of ballast and lamp, newer reserve for the future.
    factor *= numbers.next("the photometric factor")?;
    numbers.next("the power consumption")?;
    let vertical = numbers.angles(vertical, "vertical angles")?;
    let horizontal = numbers.angles(horizontal, "horizontal angles")?;
    let candela = numbers.list(vertical.len() * horizontal.len(), "an intensity")?;
    let candela: Vec<f64> = candela.into_iter().map(|c| c * factor).collect();
    if let Some(c) = candela.iter().find(|c| !(0.0..1e30).contains(*c)) {
        return Err(format!("an intensity is {c} candela"));
    }
    let (least, most) = if kind == Kind::C { (0.0, 180.0) } else { (-90.0, 90.0) };
    let around = if kind == Kind::C { 360.0 } else { most };
    let within = |angles: &[f64], least: f64, most: f64| angles.iter().all(|a| (least..=most).contains(a));
    if !within(&vertical, least, most) || !within(&horizontal, least, around) {
        return Err("angles lie outside of the range of its photometric type".to_string());
    }
    Ok(Grid { kind, vertical, horizontal, candela })
}

impl Grid {
    fn is_axial(&self) -> bool {
        self.kind == Kind::C && self.horizontal.len() == 1
    }

    /// The greatest step, at most a degree, in whose multiples all angles lie; a quarter if there is none.
    fn step(&self) -> f64 {
        if self.kind != Kind::C {
            return 0.5;
        }
        let all = || self.vertical.iter().chain(&self.horizontal);
        let fits = |step: &f64| all().all(|angle| (angle / step - (angle / step).round()).abs() < 1e-3);
        [1.0, 0.5, 0.25].into_iter().find(fits).unwrap_or(0.25)
    }

    /// Intensity at angles in degrees: θ from z, φ around it from x.
    fn candela(&self, theta: f64, phi: f64) -> f64 {
        match self.kind {
            Kind::C => self.at(theta, self.folded(phi)),
            kind => {
                let (sin, z) = theta.to_radians().sin_cos();
                let (y, x) = phi.to_radians().sin_cos();
                let (x, y) = (sin * x, sin * y);
                if z < -1e-9 {
                    return 0.0;
                }
                let (pole, turned) = if kind == Kind::A { (y, x) } else { (x, y) };
                let elevation = pole.clamp(-1.0, 1.0).asin().to_degrees();
                let around = turned.atan2(z.max(0.0)).to_degrees();
                let (v, h) = if kind == Kind::A { (elevation, around) } else { (around, elevation) };
                // What begins at 0 is the half of something symmetric.
                let folded = |x: f64, angles: &[f64]| if angles[0] >= 0.0 { x.abs() } else { x };
                self.at(folded(v, &self.vertical), folded(h, &self.horizontal))
            }
        }
    }

    /// The horizontal angle of what was measured that stands for another, by the symmetries of type C.
    fn folded(&self, phi: f64) -> f64 {
        let (first, last) = (self.horizontal[0], self.horizontal[self.horizontal.len() - 1]);
        let phi = phi.rem_euclid(360.0);
        let half = if phi > 180.0 { 360.0 - phi } else { phi };
        match last {
            _ if self.is_axial() => first,
            _ if first == 0.0 && last == 90.0 => {
                if half > 90.0 {
                    180.0 - half
                } else {
                    half
                }
            }
            _ if first == 0.0 && last == 180.0 => half,
            _ if first == 90.0 && last == 270.0 => {
                if (90.0..=270.0).contains(&phi) {
                    phi
                } else {
                    (180.0 - phi).rem_euclid(360.0)
                }
            }
            // All around: the last angle may be left out where it is the first again.
            _ => phi,
        }
    }

    /// Linear between angles; nothing beyond the vertical ones.
    fn at(&self, v: f64, h: f64) -> f64 {
        let count = self.vertical.len();
        let (first, last) = (self.vertical[0], self.vertical[count - 1]);
        if v < first - 1e-6 || v > last + 1e-6 {
            return 0.0;
        }
        let (i, fv) = place(&self.vertical, v);
        let column = |j: usize| {
            let at = |i: usize| self.candela[j * count + i.min(count - 1)];
            at(i) + (at(i + 1) - at(i)) * fv
        };
        let (h_first, h_last) = (self.horizontal[0], self.horizontal[self.horizontal.len() - 1]);
        let is_gap = self.kind == Kind::C && self.horizontal.len() > 1 && (h > h_last || h < h_first);
        if is_gap {
            // Between the last angle and the first of the next turn.
            let gap = h_first + 360.0 - h_last;
            let f = ((h - h_last).rem_euclid(360.0) / gap).min(1.0);
            let (a, b) = (column(self.horizontal.len() - 1), column(0));
            return a + (b - a) * f;
        }
        let (j, fh) = place(&self.horizontal, h);
        let next = (j + 1).min(self.horizontal.len() - 1);
        column(j) + (column(next) - column(j)) * fh
    }
}

/// The interval that holds a value, and where in it; at the ends those.
fn place(angles: &[f64], x: f64) -> (usize, f64) {
    let after = angles.partition_point(|a| *a <= x);
    match after {
        0 => (0, 0.0),
        n if n == angles.len() => (n - 1, 0.0),
        n => (n - 1, (x - angles[n - 1]) / (angles[n] - angles[n - 1])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn file(kind: u32, vertical: &str, horizontal: &str, candela: &str) -> String {
        let count = |list: &str| list.split_whitespace().count();
        format!(
            "IESNA:LM-63-2002\n[TEST] x\nTILT=NONE\n1 1000 2.0 {} {} {kind} 2 0 0 0\n1 1 50\n{vertical}\n{horizontal}\n{candela}\n",
            count(vertical),
            count(horizontal)
        )
    }

    #[test]
    fn even_light_has_the_power_of_its_solid_angle() {
        let even = parse(&file(1, "0 90 180", "0", "1 1 1")).expect("a good file");
        assert!((even.power / (8.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6 && even.maximum == 2.0);
        let half = parse(&file(1, "0 45 90", "0", "1, 1, 1")).expect("a good file");
        assert!((half.power / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6);
        // I = 90 − θ in degrees: 2π ∫ (90 − θ) sin θ dθ = 2π (90 − 180/π).
        let linear = parse(&file(1, "0 90", "0", "90 0")).expect("a good file");
        let exact = 4.0 * std::f64::consts::PI * (90.0 - 180.0 / std::f64::consts::PI);
        assert!((linear.power / exact - 1.0).abs() < 1e-6, "{}", linear.power);
        for kind in [2, 3] {
            let front = parse(&file(kind, "-90 90", "-90 90", "1 1 1 1")).expect("a good file");
            assert!((front.power / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{}", front.power);
        }
    }

    #[test]
    fn symmetries_fill_the_turn() {
        let at = |text: &str, theta: f64, phi: f64| {
            let profile = parse(text).expect("a good file");
            profile.candela(theta, phi)
        };
        let quadrant = file(1, "0 90", "0 45 90", "0 2 0 3 0 4");
        let bilateral = file(1, "0 90", "0 90 180", "0 2 0 3 0 4");
        let side = file(1, "0 90", "90 180 270", "0 2 0 3 0 4");
        let turn = file(1, "0 90", "0 90 180 270", "0 2 0 3 0 4 0 5");
        for (text, phi, expected) in [
            (&quadrant, 135.0, 6.0),
            (&quadrant, 180.0, 4.0),
            (&quadrant, 270.0, 8.0),
            (&bilateral, 90.0, 6.0),
            (&bilateral, 270.0, 6.0),
            (&bilateral, 225.0, 7.0),
            (&side, 180.0, 6.0),
            (&side, 90.0, 4.0),
            (&side, 45.0, 5.0),
            (&side, 0.0, 6.0),
            (&side, 315.0, 7.0),
            (&turn, 270.0, 10.0),
            (&turn, 315.0, 7.0),
        ] {
            let found = at(text, 90.0, phi);
            assert!((found - expected).abs() < 1e-4, "{phi}: {found} for {expected}\n{text}");
            assert!((at(text, 45.0, phi) - 0.5 * expected).abs() < 1e-4);
        }
    }

    #[test]
    fn types_a_and_b_look_along_z() {
        // Light upwards alone.
        let a = parse(&file(3, "-90 0 90", "0", "0 0 1")).expect("a good file");
        let b = parse(&file(2, "0", "-90 0 90", "0 0 1")).expect("a good file");
        assert!((a.candela(90.0, 90.0) - 2.0).abs() < 1e-3 && a.candela(90.0, 0.0) < 1e-3);
        assert!((b.candela(90.0, 0.0) - 2.0).abs() < 1e-3 && b.candela(90.0, 90.0) < 1e-3);
        assert!((a.candela(45.0, 90.0) - 1.0).abs() < 1e-2 && a.candela(135.0, 90.0) == 0.0);
    }

    #[test]
    fn broken_files_are_refused_with_the_cause() {
        let good = file(1, "0 90 180", "0", "1 2 3");
        for (text, cause) in [
            ("hello".to_string(), "no line TILT="),
            (good.replace("TILT=NONE", "TILT=lamp.tlt"), "lamp.tlt"),
            (good.replace("TILT=NONE", "TILT=NONE\nformat error"), "`format` stands where"),
            (good.replace("1 2 3", "1 2"), "it ends where an intensity"),
            (good.replace("1 2 3", "1 2 nan"), "`nan`"),
            (good.replace("1 2 3", "1 -2 3"), "-4 candela"),
            (good.replace("0 90 180", "0 180 90"), "do not ascend"),
            (good.replace("0 90 180", "0 90 190"), "outside of the range"),
            (good.replace("2.0 3 1 1", "2.0 3e9 1 1"), "number of vertical angles is 3000000000"),
            (good.replace("2.0 3 1 1", "2.0 3 1 7"), "type is 7"),
        ] {
            let error = parse(&text).map(|_| ()).expect_err(cause);
            assert!(error.contains(cause), "{error}");
        }
        let tilted = good.replace("TILT=NONE", "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8");
        assert!(parse(&tilted).is_ok());
    }

    /// Files of real lamps, where they are present.
    #[test]
    fn real_profiles_are_read() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/ies");
        if !folder.is_dir() {
            eprintln!("skipped: real_profiles_are_read: no {}", folder.display());
            return;
        }
        // 13,000 lumens of the lamp, of which the luminaire lets 77.5 percent out, by its file.
        for (name, least, most) in
            [("ASA_15M_R2.ies", 9_000.0, 11_000.0), ("test.ies", 100.0, 300.0), ("minimal.ies", 0.5, 4.0)]
        {
            let profile = load_profile(&folder.join(name)).expect("a good file");
            assert!((least..most).contains(&profile.power), "{name}: {}", profile.power);
        }
        let error = load_profile(&folder.join("broken.ies")).map(|_| ()).expect_err("broken").to_string();
        assert!(error.contains("broken.ies"), "{error}");
    }
}
