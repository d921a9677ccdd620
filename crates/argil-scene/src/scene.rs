use crate::change::SceneChange;
use crate::group_summary::GroupSummary;
use crate::history::History;
use crate::margins::{MarginRequest, MarginRequests};
use crate::node::{GONE, pose_of};
use crate::node_store::NodeStore;
use crate::{
    Group, Material, Node, NodeDesc, NodeId, NodeKind, SampledGrid, ValidationError, View,
};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A number that no other scene of the process has; a clone has its own.
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

/// What the ids of new nodes are marked with: that of the scene that a replica is of; a clone's are its own.
#[derive(Debug, Default)]
pub(crate) struct Origin(Option<u32>);

impl Clone for Origin {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// An ordered list of brushes and groups, with materials and a way to look at them. See the crate's page.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) nodes: NodeStore,
    pub(crate) time: f32,
    pub(crate) materials: BTreeMap<String, Material>,
    /// Of meshes, by path and resolution.
    pub(crate) grids: BTreeMap<(String, u32), Arc<SampledGrid>>,
    pub(crate) history: History,
    pub(crate) margin_requests: MarginRequests,
    pub(crate) summaries: HashMap<NodeId, GroupSummary>,
    pub(crate) scene_id: Identity,
    pub(crate) origin: Origin,
    /// A name for people.
    pub name: String,
    /// Where the scene or its parts come from.
    pub credit: String,
    /// How the scene is meant to be looked at.
    pub view: View,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// The group that holds everything.
    pub const ROOT: NodeId = NodeId {
        index: 0,
        origin: 0,
    };

    /// A scene with nothing in it.
    pub fn new() -> Self {
        Self {
            nodes: NodeStore::of(Node::root()),
            time: 0.0,
            materials: BTreeMap::new(),
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

    /// The scene as it stands, without its history: what a [clone](Clone) has that nobody edits. It shares the nodes that the scene does
    /// not change from then on, so that it costs little, however many there are.
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

    /// A clone in which the same [actions](crate::Action), in the same order, make nodes of the same ids: for whoever follows a scene
    /// elsewhere, as on another thread. Refused actions count for nothing.
    ///
    /// ```
    /// use argil_scene::{Action, Brush, Edit, Scene, Shape};
    /// let mut scene = Scene::new();
    /// let mut copy = scene.replica();
    /// let entry = Brush::new(Shape::sphere(1.0)).into();
    /// let insert = Action::Edit(Edit::Insert { parent: Scene::ROOT, index: 0, entry });
    /// let made = scene.perform(&insert)?.expect("an edit").node;
    /// assert_eq!(copy.perform(&insert)?.expect("an edit").node, made);
    /// # Ok::<(), argil_scene::LogError>(())
    /// ```
    pub fn replica(&self) -> Self {
        Self {
            origin: Origin(Some(self.own_origin())),
            ..self.clone()
        }
    }

    fn own_origin(&self) -> u32 {
        // Neither a root's nor that of nodes that are gone.
        let own = (self.scene_id.0 % u64::from(GONE - 1)) as u32 + 1;
        self.origin.0.unwrap_or(own)
    }

    /// A node by its id.
    ///
    /// # Panics
    /// If it is a node of another scene, or its history was dropped: see [`Scene::get`].
    pub fn node(&self, id: NodeId) -> &Node {
        let node = &self.nodes[id.index()];
        assert_eq!(node.origin, id.origin, "a node of this scene");
        node
    }

    /// A node by its id, removed nodes included. `None` for a node of another scene.
    pub fn get(&self, id: NodeId) -> Option<&Node> {
        let node = self.nodes.get(id.index())?;
        (node.origin == id.origin).then_some(node)
    }

    /// Makes a node that is not in the tree yet.
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

    /// One more than the greatest [`NodeId::index`].
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The materials by name.
    pub fn materials(&self) -> &BTreeMap<String, Material> {
        &self.materials
    }

    /// Add or change a material. Not part of the history.
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
        let old = self.materials.insert(name, material);
        if old != Some(material) {
            self.history.note(SceneChange::of_everything());
        }
        Ok(())
    }

    /// The meshes that have no distances yet: path and resolution of each.
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

    /// The meshes in the scene that have distances: path, resolution and distances of each.
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

    /// Brushes of sampled distances: name of the file, and distances of each.
    pub(crate) fn sampled(&self) -> impl Iterator<Item = (&str, &SampledGrid)> {
        let files = self.iter().filter_map(|id| self.node(id).desc.kind.file());
        files.filter_map(|(name, _, grid)| {
            let grid = grid.0.as_deref().filter(|_| crate::is_grid(name))?;
            Some((name, grid))
        })
    }

    /// The files of all meshes.
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

    /// The files of all meshes that it has had distances of, those that undo would bring back included.
    pub fn known_mesh_paths(&self) -> impl Iterator<Item = &str> {
        self.grids.keys().map(|(path, _)| path.as_str())
    }

    /// Name meshes' files by other paths, as from another folder, all at once; what is loaded stays. It is no step of the history,
    /// and what undo brings back has the new names too.
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

    /// The distances of a mesh, for all brushes that name it, in place of what they had, and those of later edits included. Not
    /// part of the history: undo does not bring back what was there. What was built before has to be built anew.
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

    /// Give a mesh its distances, where they are known.
    pub(crate) fn load(&self, entry: &mut NodeDesc) {
        if let Some((path, resolution, grid)) = entry.kind.file_mut()
            // A name is made for the look-up alone; meshes are few.
            // What was sampled in this program comes with its brush.
            && (grid.0.is_none() || !crate::is_grid(path))
            && let Some(known) = self.grids.get(&(path.clone(), *resolution))
            && known.has_heights() == crate::is_image(path)
        {
            grid.0 = Some(known.clone());
        }
    }

    /// The distances, in the scene's unit, below which the dirty and the far boxes of edits promise to hold every change: the widest
    /// of all that [watch](Scene::request_margins).
    pub fn margins(&self) -> [f32; 2] {
        self.margin_requests.maximum()
    }

    /// Have the boxes of edits hold every change below two distances, as long as what is returned is held: a volume's narrow
    /// band, and how far its empty cells see. Worlds do that by themselves.
    pub fn request_margins(&self, bands: [f32; 2]) -> MarginRequest {
        self.margin_requests.add(bands)
    }

    /// A number that no other scene of this process has, its clones included.
    pub fn identity(&self) -> u64 {
        self.scene_id.0
    }

    /// How many changes there were: edits, undone and redone ones too, and what moved with time.
    pub fn change_count(&self) -> usize {
        self.history.count()
    }

    /// The changes after the first so many; nothing where those are forgotten, as there were thousands since, or where there are
    /// not as many.
    pub fn changes_since(&self, count: usize) -> Option<&[SceneChange]> {
        self.history.since(count)
    }

    /// The operand of the root that a node is, or is in; `None` for the root and for what was removed.
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

    /// All nodes in the tree, each before what it holds, in the file's order. No recursion: depth costs heap only.
    pub fn iter(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.descendants(Self::ROOT)
    }

    /// A node and all that it holds, each before what it holds.
    pub fn descendants(&self, id: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        let mut pending = vec![id];
        std::iter::from_fn(move || {
            let id = pending.pop()?;
            pending.extend(self.node(id).children.iter().rev());
            Some(id)
        })
    }

    /// The number of brushes, hidden ones included.
    pub fn brush_count(&self) -> usize {
        self.iter()
            .filter(|&id| matches!(self.node(id).desc.kind, NodeKind::Shape(_)))
            .count()
    }

    /// The path of a node as files and messages name it, `brushes[3].brushes[0]`; empty for the root.
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

    /// Put an entry at the end of a group without a check or a step in the history.
    pub(crate) fn append(&mut self, parent: NodeId, entry: NodeDesc) -> NodeId {
        let id = self.add_node(entry, Some(parent));
        self.nodes[parent.index()].children.push(id);
        id
    }
}

/// Scenes are equal when a file would hold the same: entries in order, materials, view; not ids or history.
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
