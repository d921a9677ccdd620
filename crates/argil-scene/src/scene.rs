use crate::change::SceneChange;
use crate::group_summary::GroupSummary;
use crate::history::History;
use crate::margins::{MarginRequest, MarginRequests};
use crate::node::{GONE, pose_of};
use crate::node_store::NodeStore;
use crate::{
    Group, Material, Node, NodeDesc, NodeId, NodeKind, SampledGrid, ValidationError, View,
};
use indexmap::IndexMap;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The id of a scene within this process. A clone gets its own.
#[derive(Debug)]
pub(crate) struct Identity(u64);

impl Identity {
    fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

impl Clone for Identity {
    fn clone(&self) -> Self {
        Self::new()
    }
}

/// Marks the ids of new nodes: with the id of the scene that a replica mirrors. A clone uses its own.
#[derive(Debug, Default)]
pub(crate) struct Origin(Option<u32>);

impl Clone for Origin {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// An ordered list of brushes and groups, with materials and a view.
///
/// See the [crate page](crate) for the model. Cloning is cheap: clones share nodes until one of them changes.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) nodes: NodeStore,
    pub(crate) time: f32,
    pub(crate) materials: IndexMap<String, Material>,
    /// Samples of meshes, by path and resolution.
    pub(crate) grids: BTreeMap<(String, u32), Arc<SampledGrid>>,
    pub(crate) history: History,
    pub(crate) margin_requests: MarginRequests,
    pub(crate) summaries: HashMap<NodeId, GroupSummary>,
    pub(crate) scene_id: Identity,
    pub(crate) origin: Origin,
    /// A human-readable name.
    pub name: String,
    /// Source and license of the scene or its parts.
    pub credit: String,
    /// Camera, ground, sun and bounds.
    pub view: View,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// The group that contains everything.
    pub const ROOT: NodeId = NodeId {
        index: 0,
        origin: 0,
    };

    /// Creates an empty scene.
    pub fn new() -> Self {
        Self {
            nodes: NodeStore::of(Node::root()),
            time: 0.0,
            materials: IndexMap::new(),
            grids: BTreeMap::new(),
            history: History::default(),
            margin_requests: MarginRequests::default(),
            summaries: HashMap::new(),
            scene_id: Identity::new(),
            origin: Origin::default(),
            name: String::new(),
            credit: String::new(),
            view: View::default(),
        }
    }

    /// Returns a copy of the scene without its history. The copy shares unchanged nodes, so it costs little,
    /// however many there are.
    pub fn snapshot(&self) -> Self {
        Self {
            nodes: self.nodes.clone(),
            time: self.time,
            materials: self.materials.clone(),
            grids: self.grids.clone(),
            history: History::default(),
            margin_requests: MarginRequests::default(),
            summaries: HashMap::new(),
            scene_id: Identity::new(),
            origin: Origin::default(),
            name: self.name.clone(),
            credit: self.credit.clone(),
            view: self.view.clone(),
        }
    }

    /// Returns a clone in which the same [actions](crate::Action), in the same order, give nodes the same ids. It
    /// mirrors a scene elsewhere, such as on another thread. Refused actions do not count.
    ///
    /// ```
    /// use argil_scene::{Action, Brush, Edit, Scene, Shape};
    /// let mut scene = Scene::new();
    /// let mut copy = scene.replica();
    /// let desc = Brush::new(Shape::sphere(1.0)).into();
    /// let insert = Action::Edit(Edit::Insert { parent: Scene::ROOT, index: 0, desc });
    /// let node = scene.perform(&insert)?.expect("an edit").node;
    /// assert_eq!(copy.perform(&insert)?.expect("an edit").node, node);
    /// # Ok::<(), argil_scene::LogError>(())
    /// ```
    pub fn replica(&self) -> Self {
        Self {
            origin: Origin(Some(self.own_origin())),
            ..self.clone()
        }
    }

    fn own_origin(&self) -> u32 {
        // Neither the root's mark nor that of nodes that are gone.
        let fallback = (self.scene_id.0 % u64::from(GONE - 1)) as u32 + 1;
        self.origin.0.unwrap_or(fallback)
    }

    /// Returns a node.
    ///
    /// # Panics
    /// If the node belongs to another scene, or its history was dropped: see [`Scene::get`].
    pub fn node(&self, id: NodeId) -> &Node {
        let node = &self.nodes[id.index()];
        assert_eq!(node.origin, id.origin, "a node of this scene");
        node
    }

    /// Returns a node, which may be a removed one, or `None` for a node of another scene.
    pub fn get(&self, id: NodeId) -> Option<&Node> {
        let node = self.nodes.get(id.index())?;
        (node.origin == id.origin).then_some(node)
    }

    /// Creates a node outside the tree.
    pub(crate) fn add_node(&mut self, entry: NodeDesc, parent: Option<NodeId>) -> NodeId {
        let origin = self.own_origin();
        let id = NodeId {
            index: self.nodes.len() as u32,
            origin,
        };
        self.nodes.push(Node {
            evaluated: pose_of(&entry, self.time),
            desc: entry,
            children: Vec::new(),
            parent,
            origin,
        });
        id
    }

    /// Returns one more than the largest [`NodeId::index`].
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the materials by name, in the order in which they were added.
    pub fn materials(&self) -> &IndexMap<String, Material> {
        &self.materials
    }

    /// Adds or changes a material, without an undo step.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn set_material(
        &mut self,
        name: impl Into<String>,
        material: Material,
    ) -> Result<(), ValidationError> {
        let name = name.into();
        material.check().map_err(|f| f.within(&name))?;
        if self.materials.get(&name) != Some(&material) {
            let material = self.with_images(material);
            self.put_material(&name, Some(material), None);
        }
        Ok(())
    }

    /// Returns path and resolution of each mesh that is not loaded.
    pub fn missing_meshes(&self) -> Vec<(String, u32)> {
        let mut missing: Vec<(String, u32)> = self
            .iter()
            .filter_map(|id| self.node(id).desc.kind.file())
            .filter(|(_, _, grid)| grid.0.is_none())
            .map(|(path, resolution, _)| (path.to_owned(), resolution))
            .collect();
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    /// Returns path, resolution and samples of each loaded mesh in the scene.
    pub fn loaded_meshes(&self) -> Vec<(&str, u32, &Arc<SampledGrid>)> {
        let mut loaded: BTreeMap<(&str, u32), &Arc<SampledGrid>> = BTreeMap::new();
        for id in self.iter() {
            if let Some((path, resolution, grid)) = self.node(id).desc.kind.file()
                && let Some(grid) = &grid.0
            {
                loaded.insert((path, resolution), grid);
            }
        }
        let all = loaded.into_iter();
        all.map(|((path, resolution), grid)| (path, resolution, grid))
            .collect()
    }

    /// Iterates over sampled shapes: the name of the file, and the samples.
    pub(crate) fn sampled(&self) -> impl Iterator<Item = (&str, &SampledGrid)> {
        let files = self.iter().filter_map(|id| self.node(id).desc.kind.file());
        files.filter_map(|(name, _, grid)| {
            let grid = grid.0.as_deref().filter(|_| crate::is_grid(name))?;
            Some((name, grid))
        })
    }

    /// Returns the paths of all mesh files.
    pub fn mesh_paths(&self) -> Vec<String> {
        let mut paths: Vec<String> = self
            .iter()
            .filter_map(|id| self.node(id).desc.kind.file())
            .map(|(path, _, _)| path.to_owned())
            .collect();
        paths.sort_unstable();
        paths.dedup();
        paths
    }

    /// Iterates over the paths of all meshes that were ever loaded, including those that undo would restore.
    pub fn known_mesh_paths(&self) -> impl Iterator<Item = &str> {
        self.grids.keys().map(|(path, _)| path.as_str())
    }

    /// Renames the paths of mesh files, all at once, as for another folder. Loaded samples stay. This is not an
    /// undo step, and nodes that undo restores have the new names too.
    pub fn rename_meshes(&mut self, paths: &BTreeMap<String, String>) {
        let rename = |entry: &mut NodeDesc| {
            if let Some((path, _, _)) = entry.kind.file_mut()
                && let Some(to) = paths.get(path)
            {
                path.clone_from(to);
            }
        };
        for i in 0..self.nodes.len() {
            let is_named = |(path, ..): (&str, _, _)| paths.contains_key(path);
            if self.nodes[i].desc.kind.file().is_some_and(is_named) {
                let node = &mut self.nodes[i];
                rename(&mut node.desc);
                node.evaluated.as_deref_mut().map(rename);
            }
        }
        self.history.entries().for_each(rename);
        let grids = std::mem::take(&mut self.grids).into_iter();
        self.grids = grids
            .map(|((path, resolution), grid)| {
                let path = paths.get(&path).cloned().unwrap_or(path);
                ((path, resolution), grid)
            })
            .collect();
    }

    /// Sets the samples of a mesh, for all brushes that name it now or later. This is not an undo step. Worlds of
    /// the scene must be rebuilt.
    pub fn set_mesh_grid(
        &mut self,
        path: impl Into<String>,
        resolution: u32,
        grid: Arc<SampledGrid>,
    ) {
        self.grids.insert((path.into(), resolution), grid);
        for i in 0..self.nodes.len() {
            if self.nodes[i].desc.kind.file().is_none() {
                continue;
            }
            let mut entry = std::mem::replace(&mut self.nodes[i].desc, Group::new().into());
            self.load(&mut entry);
            self.nodes[i].evaluated = pose_of(&entry, self.time);
            self.nodes[i].desc = entry;
        }
        self.summaries.clear();
        self.history.note(SceneChange::of_everything());
    }

    /// Gives a mesh its samples, if they are known.
    pub(crate) fn load(&self, entry: &mut NodeDesc) {
        if let Some((path, resolution, grid)) = entry.kind.file_mut()
            // The name is allocated only for the look-up. A shape that was sampled in this program has its own
            // samples.
            && (grid.0.is_none() || !crate::is_grid(path))
            && let Some(known) = self.grids.get(&(path.clone(), *resolution))
            && known.has_heights() == crate::is_image(path)
        {
            grid.0 = Some(known.clone());
        }
    }

    /// Returns the margins, in the scene's unit, that dirty boxes and influence boxes have: the largest of all
    /// [requests](Scene::request_margins).
    pub fn margins(&self) -> [f32; 2] {
        self.margin_requests.maximum()
    }

    /// Requests margins for the boxes of edits, for as long as the returned value exists. Worlds do this by
    /// themselves.
    pub fn request_margins(&self, bands: [f32; 2]) -> MarginRequest {
        self.margin_requests.add(bands)
    }

    /// Returns the id of this scene within the process. Clones have ids of their own.
    pub fn id(&self) -> u64 {
        self.scene_id.0
    }

    /// Returns the number of changes so far: edits, undone and redone ones, and animated nodes.
    pub fn change_count(&self) -> usize {
        self.history.count()
    }

    /// Returns the changes after the first `count`, or `None` if they were dropped because thousands followed, or
    /// if there are fewer.
    pub fn changes_since(&self, count: usize) -> Option<&[SceneChange]> {
        self.history.since(count)
    }

    /// Returns the root's operand that contains a node, or `None` for the root and for removed nodes.
    pub fn operand_of(&self, node: NodeId) -> Option<NodeId> {
        let mut at = node;
        while let Some(parent) = self.node(at).parent {
            if parent == Self::ROOT {
                return Some(at);
            }
            at = parent;
        }
        None
    }

    /// Iterates over all nodes in the tree, each before its contents, in file order. Does not recurse.
    pub fn iter(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.descendants(Self::ROOT)
    }

    /// Iterates over a node and everything in it, each before its contents.
    pub fn descendants(&self, id: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        let mut pending = vec![id];
        std::iter::from_fn(move || {
            let id = pending.pop()?;
            pending.extend(self.node(id).children.iter().rev());
            Some(id)
        })
    }

    /// Returns the number of brushes, including hidden ones.
    pub fn brush_count(&self) -> usize {
        self.iter()
            .filter(|&id| matches!(self.node(id).desc.kind, NodeKind::Shape(_)))
            .count()
    }

    /// Returns the path of a node, as files and messages name it: `brushes[3].brushes[0]`. The root's path is
    /// empty.
    ///
    /// # Panics
    /// If `id` is not in the scene.
    pub fn path(&self, id: NodeId) -> String {
        let mut steps = Vec::new();
        let mut at = id;
        while let Some(parent) = self.node(at).parent {
            let index = self
                .node(parent)
                .children
                .iter()
                .position(|&c| c == at)
                .expect("a node is among its parent's children");
            steps.push(format!("brushes[{index}]"));
            at = parent;
        }
        steps.reverse();
        steps.join(".")
    }

    /// Appends a node to a group, without checks and without an undo step.
    pub(crate) fn append(&mut self, parent: NodeId, entry: NodeDesc) -> NodeId {
        let id = self.add_node(entry, Some(parent));
        self.nodes[parent.index()].children.push(id);
        id
    }
}

/// Compares what a file would hold: nodes in order, materials and view, but not ids or history.
impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        let same_settings = (&self.name, &self.credit, &self.view, &self.materials)
            == (&other.name, &other.credit, &other.view, &other.materials);
        let part =
            |scene: &Self, id: NodeId| (scene.node(id).desc.clone(), scene.node(id).children.len());
        same_settings
            && self.iter().count() == other.iter().count()
            && self
                .iter()
                .zip(other.iter())
                .all(|(a, b)| part(self, a) == part(other, b))
    }
}
