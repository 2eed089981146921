//! Selectors: one channel or layer of a file instead of its colour.

use super::exr::check_header;
use super::load::{Decoded, ImageLimits, Texels};
use exr::image::{AnyChannel, FlatSamples};
use exr::prelude::*;
use std::io::Cursor;
use std::result::Result;

/// Channels of colour in order.
const CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// Whether a selector means an alpha channel, whose values are never encoded.
pub fn is_alpha(selector: &str) -> bool {
    selector == "A" || selector.ends_with(".A")
}

/// One of the channels R, G, B and A as a grey.
pub(super) fn channel(decoded: Decoded, selector: &str) -> Result<Decoded, String> {
    let channel = CHANNELS
        .iter()
        .position(|name| *name == selector)
        .ok_or_else(|| format!("it has no channel `{selector}`; it has R, G, B and A"))?;
    fn grey<T: Copy>(texels: Vec<[T; 4]>, channel: usize, one: T) -> Vec<[T; 4]> {
        texels.into_iter().map(|t| [t[channel], t[channel], t[channel], one]).collect()
    }
    let texels = match decoded.texels {
        Texels::Bytes(t) => Texels::Bytes(grey(t, channel, u8::MAX)),
        Texels::Shorts(t) => Texels::Shorts(grey(t, channel, u16::MAX)),
        Texels::Floats(t) => Texels::Floats(grey(t, channel, 1.0)),
    };
    Ok(Decoded { texels, ..decoded })
}

/// A channel or layer of an OpenEXR file: `R`, `layer.R` or `layer`. Channels of a part are named after the
/// part, too.
pub(super) fn exr(bytes: &[u8], selector: &str, limits: &ImageLimits) -> Result<Decoded, String> {
    let meta = MetaData::read_from_buffered(bytes, false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        check_header(header, bytes.len(), limits)?;
    }
    let read = read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    let read = read.all_attributes().non_parallel();
    let image = read.from_buffered(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let mut names = Vec::new();
    let mut found: [Option<(Vec2<usize>, &AnyChannel<FlatSamples>)>; 4] = [None; 4];
    for layer in &image.layer_data {
        for channel in &layer.channel_data.list {
            let own = channel.name.to_string();
            let full = match &layer.attributes.layer_name {
                Some(part) if !part.to_string().is_empty() => format!("{part}.{own}"),
                _ => own.clone(),
            };
            let place = |name: &str| {
                let of_layer = name.strip_prefix(selector)?.strip_prefix('.')?;
                CHANNELS.iter().position(|channel| *channel == of_layer)
            };
            let at = if own == selector || full == selector { Some(0) } else { place(&full) };
            if let Some(slot) = at.or_else(|| place(&own)).map(|at| &mut found[at]) {
                slot.get_or_insert((layer.size, channel));
            }
            names.push(full);
        }
    }
    let Some((size, _)) = found.iter().flatten().next().copied() else {
        names.truncate(16);
        return Err(format!("it has no channel or layer `{selector}`; it has {}", names.join(", ")));
    };
    let is_layer = names.iter().any(|name| name.ends_with(&format!("{selector}.R")));
    let column = |at: usize, other: f32| -> Vec<f32> {
        let own = found[at].filter(|(own, _)| *own == size);
        own.map_or(vec![other; size.area()], |(_, channel)| channel.sample_data.values_as_f32().collect())
    };
    let red = column(0, 0.0);
    let [green, blue] = [1, 2].map(|at| if is_layer { column(at, 0.0) } else { red.clone() });
    let alpha = column(3, 1.0);
    let texels = (0..size.area()).map(|i| [red[i], green[i], blue[i], alpha[i]]).collect();
    Ok(Decoded { width: size.width() as u32, height: size.height() as u32, texels: Texels::Floats(texels) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::image::{AnyChannels, Layer};
    use exr::meta::header::LayerAttributes;

    /// Two texels of one part: a layer `diffuse` without blue, a channel `Z`.
    fn layered() -> Vec<u8> {
        let channel = |name: &str, values: [f32; 2]| AnyChannel::new(name, FlatSamples::F32(values.to_vec()));
        let list = [("diffuse.R", [1.0, 2.0]), ("diffuse.G", [3.0, 4.0]), ("Z", [5.0, 6.0])];
        let channels =
            AnyChannels::sort(list.map(|(name, values)| channel(name, values)).into_iter().collect());
        let part = LayerAttributes::named("beauty");
        let layer = Layer::new((2, 1), part, Encoding::FAST_LOSSLESS, channels);
        let mut out = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut out).expect("a small file");
        out.into_inner()
    }

    #[test]
    fn channels_and_layers_are_found_by_name() {
        let bytes = layered();
        let second = |selector: &str| {
            let decoded = exr(&bytes, selector, &ImageLimits::default()).expect(selector);
            let Texels::Floats(texels) = decoded.texels else { panic!("floats") };
            texels[1]
        };
        for (selector, expected) in [
            ("Z", [6.0, 6.0, 6.0, 1.0]),
            ("beauty.Z", [6.0, 6.0, 6.0, 1.0]),
            ("diffuse.G", [4.0, 4.0, 4.0, 1.0]),
            ("diffuse", [2.0, 4.0, 0.0, 1.0]),
            ("beauty.diffuse", [2.0, 4.0, 0.0, 1.0]),
        ] {
            assert_eq!(second(selector), expected, "{selector}");
        }
        let error = exr(&bytes, "normal", &ImageLimits::default()).map(|_| ()).expect_err("there is none");
        assert!(error.contains("`normal`") && error.contains("beauty.diffuse.R"), "{error}");
    }
}
