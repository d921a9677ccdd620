//! A small world, and stores that do to their requests what real ones do.
#![allow(unreachable_pub, reason = "what tests use")]

use argil::prelude::Brush;
use argil::scene::{Scene, Shape};
use argil_world::{PlanOptions, Store, WorldPlan};
use async_trait::async_trait;
use bytes::Bytes;
use futures_util::StreamExt;
use futures_util::stream::BoxStream;
use object_store::memory::InMemory;
use object_store::path::Path;
use object_store::{
    CopyOptions, Error, GetOptions, GetResult, GetResultPayload, ListResult, MultipartUpload,
    ObjectMeta, ObjectStore, ObjectStoreExt, PutMultipartOptions, PutOptions, PutPayload,
    PutResult, Result,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// What a store does to its requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    None,
    /// Every tenth request fails, before or after it was done.
    Fails,
    /// Every tenth request is never answered.
    Hangs,
    /// Every request takes a while.
    Delays,
    /// Tiles end too early, the first time.
    CutsOnce,
    /// Tiles always end too early.
    Cuts,
    /// All tiles are the first one that was asked for.
    Exchanges,
    /// Nothing can be written.
    Forbids,
    /// Whatever is asked for never ends, and its length is wrong.
    Endless,
}

#[derive(Debug)]
pub struct Faulty {
    inner: Arc<InMemory>,
    fault: Fault,
    requests: AtomicU64,
}

impl std::fmt::Display for Faulty {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a store")
    }
}

impl Faulty {
    fn fails(&self) -> bool {
        let index = self.requests.fetch_add(1, Ordering::Relaxed);
        self.fault == Fault::Fails && index % 10 == 3
    }

    async fn hang(&self) {
        if self.fault == Fault::Delays {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        let index = self.requests.load(Ordering::Relaxed);
        if self.fault == Fault::Hangs && index % 10 == 3 {
            self.requests.fetch_add(1, Ordering::Relaxed);
            std::future::pending::<()>().await;
        }
    }

    fn failure() -> Error {
        Error::Generic {
            store: "faulty",
            source: "503 Slow Down at https://user:hunter2@host/path?X-Signature=hunter2".into(),
        }
    }
}

#[async_trait]
impl ObjectStore for Faulty {
    async fn put_opts(&self, to: &Path, payload: PutPayload, how: PutOptions) -> Result<PutResult> {
        self.hang().await;
        if self.fault == Fault::Forbids {
            return Err(Error::PermissionDenied {
                path: to.to_string(),
                source: "no".into(),
            });
        }
        let is_late = self.requests.load(Ordering::Relaxed).is_multiple_of(2);
        let fails = self.fails();
        if fails && !is_late {
            return Err(Self::failure());
        }
        let done = self.inner.put_opts(to, payload, how).await;
        if fails { Err(Self::failure()) } else { done }
    }

    async fn put_multipart_opts(
        &self,
        to: &Path,
        how: PutMultipartOptions,
    ) -> Result<Box<dyn MultipartUpload>> {
        self.inner.put_multipart_opts(to, how).await
    }

    async fn get_opts(&self, from: &Path, how: GetOptions) -> Result<GetResult> {
        self.hang().await;
        if self.fails() {
            return Err(Self::failure());
        }
        let is_tile = from.as_ref().contains("tiles/");
        let is_first = self.requests.load(Ordering::Relaxed) % 2 == 1;
        let found = match self.fault {
            Fault::Exchanges if is_tile => {
                let all = self.inner.list(None).collect::<Vec<_>>().await;
                let tile = all
                    .into_iter()
                    .flatten()
                    .find(|meta| meta.location.as_ref().contains("tiles/0"));
                let other = tile.map_or(from.clone(), |meta| meta.location);
                self.inner.get_opts(&other, how).await?
            }
            _ => self.inner.get_opts(from, how).await?,
        };
        if self.fault == Fault::Endless {
            let part = Bytes::from(vec![0; 1 << 20]);
            let parts = futures_util::stream::repeat_with(move || Ok(part.clone())).boxed();
            return Ok(GetResult {
                payload: GetResultPayload::Stream(parts),
                ..found
            });
        }
        let cuts = self.fault == Fault::Cuts || self.fault == Fault::CutsOnce && is_first;
        if !(is_tile && cuts) {
            return Ok(found);
        }
        let (meta, attributes) = (found.meta.clone(), found.attributes.clone());
        let begin = found.range.start;
        let bytes = found.bytes().await?;
        let half = bytes.slice(..bytes.len() / 2);
        Ok(GetResult {
            range: begin..begin + half.len() as u64,
            payload: GetResultPayload::Stream(futures_util::stream::iter([Ok(half)]).boxed()),
            meta,
            attributes,
            extensions: Default::default(),
        })
    }

    fn delete_stream(
        &self,
        all: BoxStream<'static, Result<Path>>,
    ) -> BoxStream<'static, Result<Path>> {
        self.inner.delete_stream(all)
    }

    fn list(&self, prefix: Option<&Path>) -> BoxStream<'static, Result<ObjectMeta>> {
        if self.fails() {
            return futures_util::stream::iter([Err(Self::failure())]).boxed();
        }
        self.inner.list(prefix)
    }

    async fn list_with_delimiter(&self, prefix: Option<&Path>) -> Result<ListResult> {
        self.inner.list_with_delimiter(prefix).await
    }

    async fn copy_opts(&self, from: &Path, to: &Path, how: CopyOptions) -> Result<()> {
        self.inner.copy_opts(from, to, how).await
    }
}

pub fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.5)).expect("a sphere");
    let bar = Brush::new(Shape::cuboid([0.9, 0.1, 0.1])).at([0.0, 0.3, 0.0]);
    scene.push(bar.smooth(0.1)).expect("a bar");
    scene
}

pub fn plan(scene: &Scene) -> WorldPlan {
    let options = PlanOptions {
        voxel_size: 0.003,
        ..PlanOptions::default()
    };
    WorldPlan::new(scene, &options).expect("a plan")
}

pub fn store(inner: &Arc<InMemory>, fault: Fault) -> Store {
    let faulty = Faulty {
        inner: inner.clone(),
        fault,
        requests: AtomicU64::new(0),
    };
    let store = Store::of(Arc::new(faulty), Path::default(), "memory:").expect("a store");
    match fault {
        Fault::Hangs => store.with_timeout(Duration::from_millis(40)),
        _ => store,
    }
}

/// Returns all objects with their bytes.
pub fn contents(inner: &InMemory) -> Vec<(String, Bytes)> {
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    runtime.expect("a runtime").block_on(async {
        let mut all = Vec::new();
        for meta in inner.list(None).collect::<Vec<_>>().await {
            let place = meta.expect("an object").location;
            let bytes = inner.get(&place).await.expect("it").bytes().await;
            all.push((place.to_string(), bytes.expect("bytes")));
        }
        all.sort();
        all
    })
}
