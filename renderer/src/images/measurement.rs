//! Measured BSDFs: `.mbsdf` files (MDL specification, appendix "MBSDF file format").
//!
//! After the line `NVIDIA ARC MBSDF V1` follow lines `name=value`, which are not read, and parts: a line
//! `MBSDF_DATA=`, `MBSDF_DATA_REFLECTION=` (the same) or `MBSDF_DATA_TRANSMISSION=`, then little-endian
//! words: 0 for one channel or 1 for three, number of angles to the normal, number of azimuths, and one float
//! per channel by angle in, angle out and azimuth.
//!
//! Everything is bounded: sizes by what the file holds and what a table takes, numbers by being finite.

use super::load::{ImageError, ImageFile, ImageLimits, read_with};
use layered_bsdf::measured::{MAX_ANGLES, MeasuredSide, Measurement};
use layered_bsdf::tables::MAX_RECORDS;

/// Most bytes of a file.
const MAX_BYTES: u64 = 512 << 20;
/// The first line.
const SIGNATURE: &[u8] = b"NVIDIA ARC MBSDF V1\n";
/// Most bytes of a line.
const MAX_LINE: usize = 64 << 10;

/// Reads a measurement; it has one side at least.
pub fn load_measurement<'a>(file: impl Into<ImageFile<'a>>) -> Result<Measurement, ImageError> {
    let limits = ImageLimits { bytes: MAX_BYTES, ..ImageLimits::default() };
    read_with(file.into(), &limits, parse)
}

fn parse(bytes: &[u8]) -> Result<Measurement, String> {
    let mut rest = bytes
        .strip_prefix(SIGNATURE)
        .ok_or("it does not begin with the line `NVIDIA ARC MBSDF V1`, so it is no measurement")?;
    let mut measurement = Measurement::default();
    while !rest.is_empty() {
        let at = bytes.len() - rest.len();
        let (name, value) =
            line(&mut rest).ok_or_else(|| format!("no line `name=value` stands at byte {at}"))?;
        let (side, what) = match name {
            b"MBSDF_DATA" | b"MBSDF_DATA_REFLECTION" => (&mut measurement.reflection, "reflection"),
            b"MBSDF_DATA_TRANSMISSION" => (&mut measurement.transmission, "transmission"),
            _ => continue,
        };
        if !value.is_empty() {
            return Err(format!("the line before its {what} has something behind `=`"));
        }
        if side.is_some() {
            return Err(format!("it has more than one {what}"));
        }
        *side = Some(data(&mut rest, what)?);
    }
    match measurement {
        Measurement { reflection: None, transmission: None } => {
            Err("it has neither reflection nor transmission".to_string())
        }
        measurement => Ok(measurement),
    }
}

/// Takes a line: what stands before and behind its `=`.
fn line<'a>(rest: &mut &'a [u8]) -> Option<(&'a [u8], &'a [u8])> {
    let end = rest.iter().take(MAX_LINE).position(|&byte| byte == b'\n')?;
    let (line, after) = rest.split_at(end);
    let equals = line.iter().position(|&byte| byte == b'=')?;
    *rest = &after[1..];
    Some((&line[..equals], &line[equals + 1..]))
}

/// Takes the data of a part.
fn data(rest: &mut &[u8], what: &str) -> Result<MeasuredSide, String> {
    let mut word = |name: &str| -> Result<u32, String> {
        let (word, after) = rest
            .split_first_chunk::<4>()
            .ok_or_else(|| format!("it ends where {name} of its {what} is expected"))?;
        *rest = after;
        Ok(u32::from_le_bytes(*word))
    };
    let channels = match word("the number of channels")? {
        0 => 1,
        1 => 3,
        other => return Err(format!("its {what} is of type {other}; 0 and 1 are read")),
    };
    let mut angles = |name: &str| -> Result<usize, String> {
        let count = word(name)? as usize;
        match (1..=MAX_ANGLES).contains(&count) {
            true => Ok(count),
            false => Err(format!("{name} of its {what} is {count}; 1 to {MAX_ANGLES} are read")),
        }
    };
    let theta = angles("the number of angles to the normal")?;
    let phi = angles("the number of azimuths")?;
    if MeasuredSide::records(theta, phi) > MAX_RECORDS {
        return Err(format!("its {what} has {theta}² × {phi} values, which are too many"));
    }
    let count = theta * theta * phi;
    let bytes = 4 * channels * count;
    if rest.len() < bytes {
        let found = rest.len() / 4;
        return Err(format!("it ends after {found} of the {} numbers of its {what}", channels * count));
    }
    let (own, after) = rest.split_at(bytes);
    *rest = after;
    let number = |chunk: &[u8]| f32::from_le_bytes(chunk.try_into().expect("four bytes"));
    let numbers: Vec<f32> = own.chunks_exact(4).map(number).collect();
    if let Some(bad) = numbers.iter().position(|x| !x.is_finite()) {
        let cell = bad / channels;
        return Err(format!(
            "its {what} is {} at angles {} and {}, azimuth {}",
            numbers[bad],
            cell / phi / theta,
            cell / phi % theta,
            cell % phi
        ));
    }
    let values = match channels {
        1 => numbers.iter().map(|&x| [x; 3]).collect(),
        _ => numbers.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect(),
    };
    Ok(MeasuredSide { theta, phi, values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    /// A part as a file has it: its numbers count upwards from 0.
    fn part(name: &str, kind: u32, theta: u32, phi: u32) -> Vec<u8> {
        let mut bytes = format!("{name}=\n").into_bytes();
        bytes.extend([kind, theta, phi].into_iter().flat_map(u32::to_le_bytes));
        let count = theta * theta * phi * if kind == 0 { 1 } else { 3 };
        bytes.extend((0..count).flat_map(|i| (i as f32).to_le_bytes()));
        bytes
    }

    fn file(parts: &[Vec<u8>]) -> Vec<u8> {
        [SIGNATURE.to_vec(), parts.concat()].concat()
    }

    #[test]
    fn parts_are_read_in_order() {
        let bytes = file(&[
            b"about=\"a = b\"\n".to_vec(),
            part("MBSDF_DATA_TRANSMISSION", 0, 2, 4),
            part("MBSDF_DATA", 1, 2, 3),
        ]);
        let measurement = parse(&bytes).expect("a good file");
        let (reflection, transmission) = (measurement.reflection.unwrap(), measurement.transmission.unwrap());
        assert_eq!((reflection.theta, reflection.phi, transmission.phi), (2, 3, 4));
        assert_eq!((reflection.values[11], transmission.values[15]), ([33.0, 34.0, 35.0], [15.0; 3]));
    }

    #[test]
    fn broken_files_are_refused_with_the_cause() {
        let good = part("MBSDF_DATA", 1, 2, 3);
        let with = |at: usize, word: u32| {
            let mut bytes = file(std::slice::from_ref(&good));
            let at = SIGNATURE.len() + "MBSDF_DATA=\n".len() + 4 * at;
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            bytes
        };
        for (bytes, cause) in [
            (Vec::new(), "does not begin"),
            (b"NVIDIA ARC MBSDF V2\n".to_vec(), "does not begin"),
            (file(&[]), "neither reflection nor transmission"),
            (file(&[b"x=y\n".to_vec()]), "neither"),
            (file(&[b"no equals sign\n".to_vec()]), "at byte 20"),
            (file(&[vec![b'='; 100_000]]), "at byte 20"),
            (file(&[good.clone(), good.clone()]), "more than one reflection"),
            (file(&[b"MBSDF_DATA=1\n".to_vec()]), "behind `=`"),
            (file(&[b"MBSDF_DATA=\n\x01\0\0\0\x02".to_vec()]), "ends where the number of angles"),
            (file(&[good[..good.len() - 1].to_vec()]), "ends after 35 of the 36"),
            (file(&[good.clone(), b"MBSDF".to_vec()]), "at byte"),
            (with(0, 2), "type 2"),
            (with(1, 0), "angles to the normal of its reflection is 0"),
            (with(2, u32::MAX), "azimuths of its reflection is 4294967295"),
            (with(1, 4000), "too many"),
            (with(1, 200), "ends after 36 of the 360000"),
            (with(3 + 13, f32::NAN.to_bits()), "NaN at angles 0 and 1, azimuth 1"),
            (with(3 + 35, f32::INFINITY.to_bits()), "inf at angles 1 and 1, azimuth 2"),
        ] {
            let error = parse(&bytes).map(|_| ()).expect_err(cause);
            assert!(error.contains(cause), "{error}");
        }
    }

    /// Every prefix of a file, and every byte of its head changed: an error or a measurement.
    #[test]
    fn damaged_files_end_in_errors() {
        let whole = file(&[part("MBSDF_DATA_REFLECTION", 0, 2, 3), part("MBSDF_DATA_TRANSMISSION", 1, 1, 2)]);
        let mut read = 0;
        for end in 0..whole.len() {
            read += usize::from(parse(&whole[..end]).is_ok());
        }
        // The reflection alone.
        assert_eq!(read, 1);
        for at in 0..whole.len() {
            for byte in [0, 1, 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] = byte;
                let _ = parse(&bytes).map(|m| m.table());
            }
        }
    }

    /// Files of the format's own tests and of real paints, where they are present.
    #[test]
    fn real_measurements_are_read() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/measured");
        if !folder.is_dir() {
            eprintln!("skipped: real_measurements_are_read: no {}", folder.display());
            return;
        }
        let format = |name: &str| folder.join("mbsdf_format").join(name);
        let sides = |path: PathBuf| {
            let m = load_measurement(&path).unwrap_or_else(|e| panic!("{e}"));
            let angles = |side: Option<MeasuredSide>| side.map(|side| (side.theta, side.phi));
            (angles(m.reflection), angles(m.transmission))
        };
        for (name, reflection, transmission) in [
            ("test_scalar_theta_2_phi_3.mbsdf", Some((2, 3)), None),
            ("test_rgb_theta_2_phi_3.mbsdf", Some((2, 3)), None),
            ("test_reflection_scalar_theta_2_phi_3.mbsdf", Some((2, 3)), None),
            ("test_transmission_scalar_theta_2_phi_4.mbsdf", None, Some((2, 4))),
            (
                "test_reflection_scalar_theta_2_phi_3_transmission_scalar_theta_2_phi_4.mbsdf",
                Some((2, 3)),
                Some((2, 4)),
            ),
        ] {
            assert_eq!(sides(format(name)), (reflection, transmission), "{name}");
        }
        for (name, cause) in [
            ("test_none.mbsdf", "neither reflection nor transmission"),
            ("test_file_format_error.mbsdf", "does not begin with the line"),
        ] {
            let error = load_measurement(&format(name)).map(|_| ()).expect_err(name).to_string();
            assert!(error.contains(name) && error.contains(cause), "{error}");
        }
        for paint in ["carpaint_blue", "carpaint_green", "carpaint_red", "example_modules"] {
            let path = folder.join(format!("{paint}.mbsdf"));
            let reflection = load_measurement(&path).expect("a good file").reflection.expect("it reflects");
            let most = reflection.albedos().into_iter().flatten().fold(0.0, f64::max);
            let (error, negative) = (reflection.reciprocity_error(), reflection.negative_share());
            eprintln!("{paint}: albedo to {most:.3}, reciprocity error {error:.3}, negative {negative:.3}");
            assert_eq!((reflection.theta, reflection.phi), (45, 90), "{paint}");
            assert!((0.05..1.0).contains(&most), "{paint}: {most}");
        }
    }
}
