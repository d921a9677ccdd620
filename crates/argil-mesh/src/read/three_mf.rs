//! 3D Manufacturing Format: objects and their placements, in meters with y up.
//!
//! *Practice.* The model that the archive names is parsed as a stream, and so is each other part that a placement names.
//! Memory and unpacked bytes are limited by the file's size.

mod model;
mod package;
mod settings;

use super::budget::{Budget, Purpose, place};
use super::error::ReadFault;
use super::file::MeshFile;
use crate::Mesh;
use glam::{Affine3A, Mat4, Vec3};
use model::{Model, Object, Placement, Role};
use package::{Package, key};
use settings::Settings;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;

/// Maximum objects and components that are placed.
const MAX_PLACED: u32 = 100_000;
/// Maximum depth of components.
const MAX_DEPTH: u32 = 16;

struct Reader<'a> {
    package: Package<'a>,
    settings: Settings,
    models: HashMap<String, Rc<Model>>,
    data: Budget,
    copies: Budget,
    mesh: Mesh,
    placed: u32,
    /// Objects that have a place, with their parts' names.
    seen: BTreeSet<(String, u32)>,
    /// Shapes that are not read, counted.
    left_out: BTreeMap<&'static str, u64>,
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, ReadFault> {
    let mut package = Package::open(bytes)?;
    let mut data = Budget::new(Purpose::Data, bytes.len());
    let mut reader = Reader {
        settings: Settings::read(&mut package, &mut data)?,
        package,
        models: HashMap::new(),
        data,
        copies: Budget::new(Purpose::Copies, bytes.len()),
        mesh: Mesh::default(),
        placed: 0,
        seen: BTreeSet::new(),
        left_out: BTreeMap::new(),
    };
    let name = reader.package.main_model()?;
    let root = reader.model(&name)?;
    let meters = root.meters.unwrap_or(1e-3);
    let mut warnings = Vec::new();
    let mut items = root.items.clone();
    if items.is_empty() {
        items = roots(&root);
        if !items.is_empty() {
            warnings.push(
                "its build places nothing: all its objects are read, where they were made"
                    .to_owned(),
            );
        }
    }
    for item in &items {
        if item.is_printed {
            reader.add(&name, item, Affine3A::IDENTITY, 0, meters)?;
        } else {
            *reader
                .left_out
                .entry("item that is not printed")
                .or_default() += 1;
        }
    }
    // z up to y up, in meters.
    for p in &mut reader.mesh.positions {
        *p = meters * Vec3::new(p.x, p.z, -p.y);
    }
    let unplaced = reader.unplaced();
    if unplaced > 0 {
        reader
            .left_out
            .insert("object that its build does not place", unplaced);
    }
    warnings.extend(reader.left_out.iter().map(|(what, count)| {
        format!("left out {count} × {what}: only meshes in their places are read")
    }));
    Ok(MeshFile {
        mesh: reader.mesh,
        warnings,
    })
}

/// Returns placements of all objects that are not components of others.
fn roots(model: &Model) -> Vec<Placement> {
    let parts = model.objects.values().flat_map(|object| &object.components);
    let parts: BTreeSet<u32> = parts.map(|part| part.object).collect();
    let has_shape = |id: &u32| {
        let shape = &model.objects[id];
        !shape.triangles.is_empty() || !shape.components.is_empty() || !shape.left_out.is_empty()
    };
    let ids = model.objects.keys().filter(|id| !parts.contains(id));
    let mut ids: Vec<u32> = ids.filter(|id| has_shape(id)).copied().collect();
    ids.sort_unstable();
    let place = |object| Placement {
        part: None,
        object,
        transform: Affine3A::IDENTITY,
        is_printed: true,
    };
    ids.into_iter().map(place).collect()
}

impl Reader<'_> {
    /// Returns a part's model, which is read once.
    fn model(&mut self, name: &str) -> Result<Rc<Model>, ReadFault> {
        let key = key(name);
        if let Some(model) = self.models.get(&key) {
            return Ok(model.clone());
        }
        let mut model = Model::read(&mut self.package, name, &mut self.data)?;
        self.settings.apply(&mut model);
        let model = Rc::new(model);
        self.models.insert(key, model.clone());
        Ok(model)
    }

    /// Counts objects with triangles that have no place.
    fn unplaced(&self) -> u64 {
        let all = self.models.iter();
        let objects = all.flat_map(|(name, model)| {
            model
                .objects
                .iter()
                .map(move |(&id, object)| (name, id, object))
        });
        let unplaced = objects.filter(|(name, id, object)| {
            !object.triangles.is_empty()
                && object.role == Role::Model
                && !self.seen.contains(&((*name).clone(), *id))
        });
        unplaced.count() as u64
    }

    /// Adds an object and its components. `from` is the part that names it, whose placement is `outer`.
    fn add(
        &mut self,
        from: &str,
        item: &Placement,
        outer: Affine3A,
        depth: u32,
        root_meters: f32,
    ) -> Result<(), ReadFault> {
        let name = item.part.as_deref().unwrap_or(from);
        let id = item.object;
        let model = self.model(name)?;
        let Some(object) = model.objects.get(&id) else {
            return Err(format!("object {id} is missing in {name}").into());
        };
        if depth > MAX_DEPTH {
            return Err(format!(
                "the components of object {id} are nested more than {MAX_DEPTH} deep"
            )
            .into());
        }
        self.placed += 1;
        if self.placed > MAX_PLACED {
            let what = format!("it places more than {MAX_PLACED} objects, which is the maximum");
            return Err(ReadFault::TooLarge(what));
        }
        self.seen.insert((key(name), id));
        if object.role == Role::Other {
            *self
                .left_out
                .entry("support, or object that is not printed")
                .or_default() += 1;
            return Ok(());
        }
        for (&shape, count) in &object.left_out {
            *self.left_out.entry(shape).or_default() += count;
        }
        let mut placement = outer * item.transform;
        // Other parts may have another unit.
        if name != from
            && let Some(meters) = model.meters
        {
            placement *= Affine3A::from_scale(Vec3::splat(meters / root_meters));
        }
        self.copy(id, object, placement)?;
        for part in &object.components {
            self.add(
                name,
                part,
                placement,
                depth + 1,
                model.meters.unwrap_or(root_meters),
            )?;
        }
        Ok(())
    }

    /// Adds an object's triangles.
    fn copy(&mut self, id: u32, object: &Object, placement: Affine3A) -> Result<(), ReadFault> {
        let count = object.positions.len() as u32;
        if object
            .triangles
            .iter()
            .flatten()
            .any(|&corner| corner >= count)
        {
            return Err(format!("a triangle of object {id} refers to a missing vertex").into());
        }
        // The vertices of a beam lattice are no triangles'.
        if object.triangles.is_empty() {
            return Ok(());
        }
        self.copies
            .take_copies(1, object.positions.len(), object.triangles.len())?;
        place(
            &object.positions,
            &object.triangles,
            Mat4::from(placement),
            &mut self.mesh,
        );
        Ok(())
    }
}
