//! Texts of a release: bill of materials, the changelog's part, checksums.

use super::{Maker, UNFILLED, VERSION};
use crate::files::{read, write};
use narx_report::steps::{Outcome, output};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// File of the checksums.
pub(super) const SUMS: &str = "SHA256SUMS";

/// Packages that are in an artefact.
const RELEASED: [&str; 14] = [
    "narx-core",
    "narx-board",
    "narx-boot",
    "narx-ffi",
    "narx-python",
    "narx-fmu",
    "narx-terminal",
    "narx-firmware",
    "narx-b-g431b-esc1",
    "narx-wasm",
    "narx-wasm-core",
    "narx-wasm-full",
    "narx-wasm-lab",
    "narx-wasm-transcript",
];

impl Maker<'_> {
    /// Writes the texts; the checksums last.
    pub(super) fn texts(&self) -> Outcome {
        let changelog = read(&self.root.join("CHANGELOG.md"))?;
        let changes = part(&changelog).ok_or(format!("CHANGELOG.md has no part {VERSION}"))?;
        write(&self.out.join("CHANGES.md"), changes)?;
        let metadata = self.metadata()?;
        let bill = self.bill(&metadata)?;
        let count = bill["components"].as_array().map_or(0, Vec::len);
        write(&self.out.join("narx.cdx.json"), &format!("{bill:#}\n"))?;
        let found = output(self.call("find", &["-type", "f", "-printf", "%P\\n"]).current_dir(&self.out))?;
        let mut names: Vec<&str> = found.lines().collect();
        names.sort_unstable();
        let sums = output(self.call("sha256sum", &[]).args(&names).current_dir(&self.out))?;
        write(&self.out.join(SUMS), &sums)?;
        let mut lines = vec![
            format!("{} files in {}", names.len() + 1, self.out.display()),
            format!("{count} components in the bill of materials"),
        ];
        if env!("CARGO_PKG_REPOSITORY").ends_with(UNFILLED) {
            lines.push(
                "not to be published yet: `repository` in Cargo.toml is no address of the project".into(),
            );
        }
        Ok(lines)
    }

    /// Returns the bill of materials in the form of CycloneDX 1.5: every crate that is compiled into an
    /// artefact, and what the page has of npm.
    fn bill(&self, metadata: &Value) -> Result<Value, String> {
        let lock: toml::Table = parse(&self.root.join("Cargo.lock"))?;
        let locked = lock.get("package").and_then(toml::Value::as_array).into_iter().flatten();
        let sums: BTreeMap<(&str, &str), &str> = locked
            .filter_map(|package| {
                let text = |key| package.get(key).and_then(toml::Value::as_str);
                Some(((text("name")?, text("version")?), text("checksum")?))
            })
            .collect();
        let compiled = compiled(metadata)?;
        let packages = list(&metadata["packages"]).filter(|package| compiled.contains(text(&package["id"])));
        let mut components: Vec<Value> = packages
            .map(|package| {
                let (name, version) = (text(&package["name"]), text(&package["version"]));
                let hashes =
                    sums.get(&(name, version)).map(|sum| json!([{ "alg": "SHA-256", "content": sum }]));
                component(&format!("pkg:cargo/{name}@{version}"), name, version, &package["license"], hashes)
            })
            .collect();
        let page: Value = parse_json(&self.root.join("wasm/web/package-lock.json"))?;
        for (path, package) in page["packages"].as_object().into_iter().flatten() {
            // Those that only build the page are marked.
            if let Some(name) = path.strip_prefix("node_modules/")
                && package["dev"] != json!(true)
            {
                let version = text(&package["version"]);
                let purl = format!("pkg:npm/{}@{version}", name.replace('@', "%40"));
                components.push(component(&purl, name, version, &package["license"], None));
            }
        }
        components.sort_by_key(|component| text(&component["purl"]).to_owned());
        components.dedup();
        Ok(json!({
            "bomFormat": "CycloneDX",
            "specVersion": "1.5",
            "version": 1,
            "metadata": { "component": {
                "type": "library", "name": "narx", "version": VERSION,
                "licenses": [{ "expression": env!("CARGO_PKG_LICENSE") }],
            } },
            "components": components,
        }))
    }
}

/// Returns the packages that are compiled into an artefact, by what they use at build time or run time.
fn compiled(metadata: &Value) -> Result<BTreeSet<&str>, String> {
    let nodes: BTreeMap<&str, &Value> =
        list(&metadata["resolve"]["nodes"]).map(|node| (text(&node["id"]), node)).collect();
    let root = |name: &&str| {
        let mut packages = list(&metadata["packages"]).filter(|package| package["source"].is_null());
        let package = packages.find(|package| text(&package["name"]) == *name);
        package.map(|package| text(&package["id"])).ok_or(format!("the workspace has no package {name}"))
    };
    let mut open = RELEASED.iter().map(root).collect::<Result<Vec<&str>, String>>()?;
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        if found.insert(id) {
            let used = nodes.get(id).into_iter().flat_map(|node| list(&node["deps"]));
            let used = used.filter(|used| list(&used["dep_kinds"]).any(|kind| kind["kind"] != json!("dev")));
            open.extend(used.map(|used| text(&used["pkg"])));
        }
    }
    Ok(found)
}

fn component(purl: &str, name: &str, version: &str, license: &Value, hashes: Option<Value>) -> Value {
    let mut made =
        json!({ "type": "library", "name": name, "version": version, "purl": purl, "bom-ref": purl });
    if let Some(license) = license.as_str() {
        // Some packages write a slash for "or".
        made["licenses"] = json!([{ "expression": license.replace('/', " OR ").replace("  ", " ") }]);
    }
    if let Some(hashes) = hashes {
        made["hashes"] = hashes;
    }
    made
}

/// Returns the changelog's part of this version.
fn part(changelog: &str) -> Option<&str> {
    let start = changelog.find(&format!("## {VERSION} "))?;
    let rest = &changelog[start..];
    Some(rest.get(3..)?.find("\n## ").map_or(rest, |end| &rest[..end + 4]))
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn parse(path: &Path) -> Result<toml::Table, String> {
    read(path)?.parse().map_err(|error| format!("{}: {error}", path.display()))
}

fn parse_json(path: &Path) -> Result<Value, String> {
    serde_json::from_str(&read(path)?).map_err(|error| format!("{}: {error}", path.display()))
}
