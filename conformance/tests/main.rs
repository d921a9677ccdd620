//! All tests of this crate, as one program: its parts are linked once.

mod abi;
mod bake_history;
mod bounds;
mod bricks;
mod budgets;
mod clips;
mod columns;
mod copies;
mod edits;
mod field;
mod growth;
mod import;
mod light;
mod manifold;
mod mesh;
mod motion;
mod near_lists;
mod normals;
mod octree_bricks;
mod prune;
mod render;
mod surface_reach;
mod tables;
mod textures;
mod uniform_branches;
mod volume;
