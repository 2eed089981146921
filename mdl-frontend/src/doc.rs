//! Documentation of a module, made of its declarations and annotations: a page of Markdown.

use crate::compiler::{AnnotationInfo, CheckedModule, FunctionInfo, ParameterInfo, TypeContent, TypeInfo};
use crate::value::Value;
use std::fmt::Write;

/// The page of a module: what it says about itself, then each exported material and function with its
/// parameters, each struct with its fields and each enumeration with its values. What is marked `anno::hidden` is left out.
pub fn page(module: &CheckedModule) -> String {
    let annotations = module.annotations();
    let title = text(&annotations, "display_name").unwrap_or_else(|| module.name());
    let mut page = format!("# {}\n", escaped(&title));
    about(&mut page, &annotations);
    _ = write!(page, "\n`import {}::*;`, MDL {}\n", module.name(), module.version());
    let sections = [("Materials", module.materials()), ("Functions", module.functions())];
    for (heading, declarations) in sections {
        let shown: Vec<&FunctionInfo> =
            declarations.iter().filter(|info| find(&info.annotations, "hidden").is_none()).collect();
        if !shown.is_empty() {
            _ = write!(page, "\n## {heading}\n");
        }
        shown.into_iter().for_each(|info| declaration(&mut page, info));
    }
    let types = module.types();
    let shown: Vec<&TypeInfo> =
        types.iter().filter(|info| find(&info.annotations, "hidden").is_none()).collect();
    if !shown.is_empty() {
        page.push_str("\n## Types\n");
    }
    shown.into_iter().for_each(|info| declared_type(&mut page, info));
    page
}

/// What annotations say about a module, material or function as a whole.
fn about(page: &mut String, annotations: &[AnnotationInfo]) {
    if let Some(why) = find(annotations, "deprecated") {
        let why = string(why, 0).map_or(String::new(), |why| format!(": {}", escaped(&why)));
        _ = write!(page, "\n**Deprecated**{why}\n");
    }
    for name in ["description", "usage"] {
        if let Some(text) = text(annotations, name) {
            _ = write!(page, "\n{}\n", escaped(&text));
        }
    }
    let mut facts = Vec::new();
    for (name, label) in [
        ("author", "Author"),
        ("contributor", "Contributor"),
        ("copyright_notice", "Copyright"),
        ("version", "Version"),
        ("created", "Created"),
        ("modified", "Modified"),
        ("key_words", "Keywords"),
    ] {
        for used in annotations.iter().filter(|used| is(used, name)) {
            facts.push(format!("- {label}: {}", escaped(&values(used, name))));
        }
    }
    if !facts.is_empty() {
        _ = write!(page, "\n{}\n", facts.join("\n"));
    }
}

/// The arguments of an annotation for people.
fn values(used: &AnnotationInfo, name: &str) -> String {
    let shown: Vec<String> = used.arguments.iter().map(|(_, value)| plain(value)).collect();
    match (name, &shown[..]) {
        ("version", [major, minor, patch, rest @ ..]) => {
            let prerelease = rest.first().filter(|text| !text.is_empty());
            format!("{major}.{minor}.{patch}{}", prerelease.map_or(String::new(), |text| format!("-{text}")))
        }
        ("created" | "modified", [year, month, day, notes @ ..]) => {
            let notes = notes.first().filter(|text| !text.is_empty());
            let notes = notes.map_or(String::new(), |text| format!(", {text}"));
            format!("{year}-{month:0>2}-{day:0>2}{notes}")
        }
        _ => shown.join(", "),
    }
}

fn declaration(page: &mut String, info: &FunctionInfo) {
    let annotations = &info.annotations;
    _ = write!(
        page,
        "\n### {}\n",
        text(annotations, "display_name").map_or(info.name.to_string(), |name| escaped(&name))
    );
    let params: Vec<&str> = info.parameters.iter().map(|parameter| &*parameter.name).collect();
    _ = write!(page, "\n`{} {}({})`\n", info.result, info.name, params.join(", "));
    if let Some(original) = &info.variant_of {
        _ = write!(page, "\nA variant of `{original}`.\n");
    }
    about(page, annotations);
    table(page, "Parameter", &info.parameters);
}

fn declared_type(page: &mut String, info: &TypeInfo) {
    let title = text(&info.annotations, "display_name").map_or(info.name.to_string(), |name| escaped(&name));
    let keyword = match info.content {
        TypeContent::Enum(_) => "enum",
        TypeContent::Struct(_) => "struct",
    };
    _ = write!(page, "\n### {title}\n\n`{keyword} {}`\n", info.name);
    about(page, &info.annotations);
    match &info.content {
        TypeContent::Struct(fields) => table(page, "Field", fields),
        TypeContent::Enum(values) => {
            page.push_str("\n| Value | Number | Description |\n|---|---|---|\n");
            for value in values.iter().filter(|value| find(&value.annotations, "hidden").is_none()) {
                let name = text(&value.annotations, "display_name");
                let name = name.map(|name| format!("**{}**", cell(&escaped(&name))));
                let about = text(&value.annotations, "description").map(|text| cell(&escaped(&text)));
                let about: Vec<String> = name.into_iter().chain(about).collect();
                _ = writeln!(page, "| `{}` | {} | {} |", value.name, value.number, about.join(": "));
            }
        }
    }
}

/// A row per parameter or field that is not hidden.
fn table(page: &mut String, what: &str, parameters: &[ParameterInfo]) {
    let shown: Vec<&ParameterInfo> = parameters.iter().filter(|parameter| !parameter.ui.hidden).collect();
    if shown.is_empty() {
        return;
    }
    _ = write!(
        page,
        "\n| {what} | Type | Default | Range | Group | Description |\n|---|---|---|---|---|---|\n",
    );
    shown.into_iter().for_each(|parameter| row(page, parameter));
}

fn row(page: &mut String, parameter: &ParameterInfo) {
    let ParameterInfo { name, ty, uniform, default, ui, annotations } = parameter;
    let qualifier = if *uniform { "uniform " } else { "" };
    let default = default.as_deref().map_or(String::new(), |text| format!("`{}`", cell(text)));
    let range = |range: &Option<(Value, Value)>, note: &str| {
        range.as_ref().map(|(min, max)| format!("{} to {}{note}", plain(min), plain(max)))
    };
    let ranges = [range(&ui.hard_range, ""), range(&ui.soft_range, " (soft)")];
    let ranges: Vec<String> = ranges.into_iter().flatten().collect();
    let groups: Vec<String> = ui.groups.iter().map(|group| cell(&escaped(group))).collect();
    let mut about: Vec<String> = Vec::new();
    about.extend(ui.display_name.as_deref().map(|name| format!("**{}**", cell(&escaped(name)))));
    about.extend(ui.description.as_deref().map(|text| cell(&escaped(text))));
    about.extend(text(annotations, "enable_if").map(|text| format!("Only if `{}`.", cell(&text))));
    _ = writeln!(
        page,
        "| `{name}` | `{qualifier}{ty}` | {default} | {} | {} | {} |",
        ranges.join(", "),
        groups.join(" / "),
        about.join(": ").replace(".: Only", ". Only")
    );
}

fn is(used: &AnnotationInfo, name: &str) -> bool {
    used.name.strip_prefix("::anno::") == Some(name)
}

fn find<'a>(annotations: &'a [AnnotationInfo], name: &str) -> Option<&'a AnnotationInfo> {
    annotations.iter().find(|used| is(used, name))
}

fn string(used: &AnnotationInfo, index: usize) -> Option<String> {
    match used.arguments.get(index)? {
        (_, Value::String(text)) => Some(text.to_string()),
        _ => None,
    }
}

/// The first argument of a standard annotation, if it is there.
fn text(annotations: &[AnnotationInfo], name: &str) -> Option<String> {
    string(find(annotations, name)?, 0)
}

/// A value as people write it: strings without quotes, vectors and arrays with commas.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.to_string(),
        Value::Bool(value) => value.to_string(),
        Value::Int(value) => value.to_string(),
        Value::Float(value) => value.to_string(),
        Value::Double(value) => value.to_string(),
        other => other.elements().iter().map(plain).collect::<Vec<_>>().join(", "),
    }
}

/// Text that means nothing in Markdown.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        if matches!(c, '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '#') {
            escaped.push('\\');
        }
        escaped.push(c);
    }
    escaped.trim().to_string()
}

/// Text for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Compiler;
    use crate::loader::MemoryLoader;

    const MODULE: &str = r#"mdl 1.7; import ::anno::*;
        module [[ anno::description("Woods *and* more."), anno::version(1, 2, 3, "beta"), anno::author("me"),
            anno::created(2024, 5, 1, "first"), anno::key_words(string[]("wood", "oak")) ]];
        export material oak(
            color tint = color(0.5, 0.25, 0.1) [[ anno::display_name("Tint"), anno::description("Of a|b."),
                anno::in_group("Look", "Colour") ]],
            uniform int rings = 3 [[ anno::hard_range(1, 9), anno::soft_range(2, 5), anno::enable_if("tint == x") ]],
            float secret = 1.0 [[ anno::hidden() ]]
        ) [[ anno::display_name("Oak_1"), anno::deprecated("use ash") ]] = material();
        export material red(*) = oak(rings: 4);
        export material gone() [[ anno::hidden() ]] = material();
        export float f(float x) = x;
        export enum cut [[ anno::description("How it is sawn.") ]] { plain [[ anno::display_name("Flat") ]], rift = 4 };
        export struct grain { cut sawn; float width = 0.5 [[ anno::hard_range(0.0, 1.0) ]]; };"#;

    #[test]
    fn page_tells_what_annotations_tell() {
        let compiler = Compiler::new(MemoryLoader::new().with("::pkg::wood", MODULE));
        let module = compiler.check("::pkg::wood").expect("found");
        assert_eq!(
            page(&module),
            r"# ::pkg::wood

Woods \*and\* more.

- Author: me
- Version: 1.2.3-beta
- Created: 2024-05-01, first
- Keywords: wood, oak

`import ::pkg::wood::*;`, MDL 1.7

## Materials

### Oak\_1

`material oak(tint, rings, secret)`

**Deprecated**: use ash

| Parameter | Type | Default | Range | Group | Description |
|---|---|---|---|---|---|
| `tint` | `color` | `color(0.5, 0.25, 0.1)` |  | Look / Colour | **Tint**: Of a\|b. |
| `rings` | `uniform int` | `3` | 1 to 9, 2 to 5 (soft) |  | Only if `tint == x`. |

### red

`material red(tint, rings, secret)`

A variant of `::pkg::wood::oak`.

| Parameter | Type | Default | Range | Group | Description |
|---|---|---|---|---|---|
| `tint` | `color` | `color(0.5, 0.25, 0.1)` |  | Look / Colour | **Tint**: Of a\|b. |
| `rings` | `uniform int` | `4` | 1 to 9, 2 to 5 (soft) |  | Only if `tint == x`. |

## Functions

### f

`float f(x)`

| Parameter | Type | Default | Range | Group | Description |
|---|---|---|---|---|---|
| `x` | `float` |  |  |  |  |

## Types

### cut

`enum cut`

How it is sawn.

| Value | Number | Description |
|---|---|---|
| `plain` | 0 | **Flat** |
| `rift` | 4 |  |

### grain

`struct grain`

| Field | Type | Default | Range | Group | Description |
|---|---|---|---|---|---|
| `sawn` | `::pkg::wood::cut` |  |  |  |  |
| `width` | `float` | `0.5` | 0 to 1 |  |  |
"
        );
    }
}
