//! Worlds on web servers, as a page reads them.

use crate::browser::said;
use crate::open_world::{FoundWorld, OpenWorld};
use crate::render_worker::StoredPages;
use anyhow::Context;
use argil::volume::{TileAddress, TileSource, TileState};
use argil_world::{
    MAX_MESH_BYTES, MAX_TEXT_BYTES, MAX_TILE_BYTES, MOST_DELTAS, Manifest, TileCache, apply_delta,
    delta_name, is_delta, tile_name,
};
use eframe::egui;
use js_sys::{Reflect, Uint8Array};
use std::cell::RefCell;
use std::collections::HashSet;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{
    AbortSignal, Headers, ReadableStreamDefaultReader, RequestInit, Response, UrlSearchParams,
};

/// Maximum bytes of tiles in memory, besides the pages that are shown.
const TILE_BYTES: u64 = 128 << 20;
/// How long an answer may take.
const TIMEOUT_MS: u32 = 60_000;
/// Tiles that are fetched at once.
const AT_ONCE: usize = 24;

thread_local! {
    static ARRIVED: RefCell<Vec<anyhow::Result<FoundWorld>>> = const { RefCell::new(Vec::new()) };
}

/// Returns the address of the world that the page's own address asks for: `?world=ADDRESS`.
pub(crate) fn asked_for() -> Option<String> {
    let search = web_sys::window()?.location().search().ok()?;
    let asked = UrlSearchParams::new_with_str(&search).ok()?.get("world")?;
    let folder = asked.strip_suffix("manifest.json").unwrap_or(&asked);
    Some(folder.trim_end_matches('/').to_owned())
}

/// Whether the page's own address asks for a world.
pub(crate) fn is_asked_for() -> bool {
    asked_for().is_some()
}

/// Returns the worlds that were read since the last call.
pub(crate) fn arrived() -> Vec<anyhow::Result<FoundWorld>> {
    ARRIVED.with_borrow_mut(std::mem::take)
}

/// Begins to read a world.
pub(crate) fn fetch(ctx: &egui::Context, folder: String) {
    let ctx = ctx.clone();
    spawn_local(async move {
        let found = read(&ctx, &folder).await.with_context(|| folder.clone());
        ARRIVED.with_borrow_mut(|all| all.push(found));
        ctx.request_repaint();
    });
}

async fn read(ctx: &egui::Context, folder: &str) -> anyhow::Result<FoundWorld> {
    let manifest = get(&format!("{folder}/manifest.json"), None, MAX_TEXT_BYTES).await?;
    let (_, manifest) = manifest.context("there is no manifest.json of a finished world")?;
    let plan = Manifest::from_bytes(&manifest, &format!("{folder}/manifest.json"))?.plan;
    let mut planned = plan.scene()?;
    for (index, name) in plan.mesh_names().enumerate() {
        let bytes = get(&format!("{folder}/{name}"), None, MAX_MESH_BYTES).await?;
        let bytes = bytes.map(|(_, bytes)| bytes).unwrap_or_default();
        plan.set_mesh(&mut planned, index, &bytes, folder)?;
    }
    let (mut deltas, mut scene) = (Vec::new(), planned.clone());
    let mut left = MAX_TEXT_BYTES;
    while deltas.len() < MOST_DELTAS {
        let place = format!("{folder}/{}", delta_name(deltas.len() as u32 + 1));
        // A server that shows no list forbids what it does not have.
        let (status, bytes) = ask(&place, None, left).await?;
        left -= bytes.len() as u64;
        if matches!(status, 401 | 403 | 404) || !is_delta(&bytes) {
            break;
        }
        anyhow::ensure!(status == 200, "{place}: the server answers {status}");
        apply_delta(&mut scene, &bytes, &place)?;
        deltas.push(String::from_utf8(bytes).with_context(|| place)?);
    }
    let tiles = Tiles {
        folder: folder.to_owned(),
        cache: TileCache::new(&plan, &planned, TILE_BYTES)?,
        pending: Mutex::default(),
        ctx: ctx.clone(),
    };
    Ok(FoundWorld {
        address: argil_world::redacted(folder),
        planned,
        deltas,
        world: OpenWorld {
            pages: StoredPages {
                options: plan.levels_options(),
                source: Arc::new(WebTiles(Arc::new(tiles))),
            },
        },
    })
}

/// The tiles of a world on a web server.
#[derive(Debug)]
struct Tiles {
    folder: String,
    cache: TileCache,
    /// Tiles that are on their way.
    pending: Mutex<HashSet<TileAddress>>,
    ctx: egui::Context,
}

impl Tiles {
    async fn take(&self, address: TileAddress, level: u32) -> anyhow::Result<()> {
        // The head with coarse levels, and then the others that are wanted.
        for _ in 0..3 {
            if self.cache.get(address, level).is_some() {
                return Ok(());
            }
            let range = self.cache.wanted(address, level);
            let place = format!("{}/{}", self.folder, tile_name(address));
            let (begin, bytes) = get(&place, Some(range), MAX_TILE_BYTES)
                .await?
                .context("the server does not have it")?;
            self.cache
                .add(address, begin, &bytes)
                .map_err(anyhow::Error::msg)?;
        }
        anyhow::ensure!(self.cache.get(address, level).is_some(), "it is incomplete");
        Ok(())
    }
}

/// Shares them with what fetches.
#[derive(Debug)]
struct WebTiles(Arc<Tiles>);

impl TileSource for WebTiles {
    fn prefetch(&self, wanted: &[(TileAddress, u32)]) {
        let tiles = &self.0;
        for &(address, level) in wanted {
            let mut pending = tiles.pending.lock().unwrap_or_else(PoisonError::into_inner);
            let is_wanted = tiles.cache.is_wanted(address, level);
            if is_wanted && pending.len() < AT_ONCE && pending.insert(address) {
                let tiles = tiles.clone();
                spawn_local(async move {
                    if let Err(error) = tiles.take(address, level).await {
                        tiles.cache.fail(address, format!("{error:#}"));
                    }
                    let mut pending = tiles.pending.lock().unwrap_or_else(PoisonError::into_inner);
                    pending.remove(&address);
                    drop(pending);
                    tiles.ctx.request_repaint();
                });
            }
        }
    }

    fn tile(&self, address: TileAddress, level: u32) -> TileState {
        self.prefetch(&[(address, level)]);
        let known = self.0.cache.state(address, level);
        known.unwrap_or(TileState::Pending)
    }
}

/// Fetches an object, or a part of it. Returns where it begins, and its bytes. `None` if there is no such object. Servers
/// without ranges send all of it. More than `max_bytes` is an error.
async fn get(
    address: &str,
    range: Option<Range<u64>>,
    max_bytes: u64,
) -> anyhow::Result<Option<(u64, Vec<u8>)>> {
    let begin = range.as_ref().map_or(0, |range| range.start);
    match ask(address, range, max_bytes).await? {
        (206, bytes) => Ok(Some((begin, bytes))),
        (200, bytes) => Ok(Some((0, bytes))),
        (404, _) => Ok(None),
        (status, _) => anyhow::bail!("{address}: the server answers {status}"),
    }
}

/// Returns a server's status and what it sends. More than `max_bytes` is an error, and so is an answer that takes too long.
async fn ask(
    address: &str,
    range: Option<Range<u64>>,
    max_bytes: u64,
) -> anyhow::Result<(u16, Vec<u8>)> {
    let fetched = async {
        let options = RequestInit::new();
        options.set_signal(Some(&AbortSignal::timeout_with_u32(TIMEOUT_MS)));
        if let Some(Range { start, end }) = range {
            let headers = Headers::new()?;
            headers.set("Range", &format!("bytes={start}-{}", end - 1))?;
            options.set_headers(&headers);
        }
        let window = web_sys::window().ok_or_else(|| JsValue::from_str("there is no page"))?;
        let answer = JsFuture::from(window.fetch_with_str_and_init(address, &options)).await?;
        let answer: Response = answer.dyn_into()?;
        Ok::<_, JsValue>((answer.status(), body(&answer, max_bytes).await?))
    };
    fetched.await.map_err(|error| {
        said(&error).context(format!(
            "{address}: it cannot be fetched. The server may not allow other pages to read it (CORS)"
        ))
    })
}

/// Reads what a server sends, part by part. Lengths that servers name can be wrong.
async fn body(answer: &Response, max_bytes: u64) -> Result<Vec<u8>, JsValue> {
    let mut bytes = Vec::new();
    let Some(stream) = answer.body() else {
        return Ok(bytes);
    };
    let reader: ReadableStreamDefaultReader = stream.get_reader().dyn_into()?;
    loop {
        let part = JsFuture::from(reader.read()).await?;
        if Reflect::get(&part, &"done".into())?.is_truthy() {
            return Ok(bytes);
        }
        let part: Uint8Array = Reflect::get(&part, &"value".into())?.dyn_into()?;
        if bytes.len() as u64 + u64::from(part.length()) > max_bytes {
            // Whatever comes of it, nothing more is read.
            let _ = reader.cancel();
            let reason = format!("it has more than {max_bytes} bytes, the most that it can have");
            return Err(js_sys::Error::new(&reason).into());
        }
        bytes.extend(part.to_vec());
    }
}
