//! Folders and object stores.

use crate::WorldError;
use crate::redact::redacted;
#[cfg(feature = "cloud")]
use crate::transfer::settings;
use crate::transfer::{body, gives_parts, may_pass};
use bytes::Bytes;
use futures_util::TryStreamExt;
use object_store::path::Path;
use object_store::{
    Error, GetOptions, ObjectStore, ObjectStoreExt, PutMode, PutOptions, PutPayload,
};
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::{Builder, Handle, Runtime};

/// How often something is tried, and the pause before the second time. Each pause is twice as long as the one before. Stores
/// behind the network try ten times by themselves.
const TRIES: u32 = 6;
#[cfg(feature = "cloud")]
const NETWORK_TRIES: u32 = 2;
const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// How long a request may take.
const TIMEOUT: Duration = Duration::from_secs(60);

/// A folder, an object store or a web server.
///
/// Whatever fails is tried again a few times. A folder's objects appear as a whole or not at all, as in an object store.
#[derive(Clone, Debug)]
pub struct Store {
    inner: Arc<dyn ObjectStore>,
    prefix: Path,
    /// For messages: without secrets.
    place: String,
    tries: u32,
    timeout: Duration,
    runtime: Arc<Threads>,
}

impl Store {
    /// Opens a store to write to, as [`Store::open`] does. Creates a folder that does not exist.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub fn create(address: &str) -> Result<Self, WorldError> {
        if let Some(folder) = folder_of(address) {
            let created = std::fs::create_dir_all(folder);
            created.map_err(|reason| WorldError::Io {
                path: folder.into(),
                reason,
            })?;
        }
        Self::open(address)
    }

    /// Opens a store by its address: a folder, or `s3://…`, `gs://…`, `az://…`, `http://…` or `https://…`. The latter need the feature
    /// `cloud`. Credentials and settings come from the environment, under the names that the stores' own tools use: `AWS_…`,
    /// `GOOGLE_…` and `AZURE_…`. No other variable counts.
    ///
    /// # Errors
    /// If the address cannot be used, or the folder does not exist.
    pub fn open(address: &str) -> Result<Self, WorldError> {
        let Some(folder) = folder_of(address) else {
            return Self::open_address(address);
        };
        std::fs::read_dir(folder).map_err(|reason| WorldError::Io {
            path: folder.into(),
            reason,
        })?;
        let opened = object_store::local::LocalFileSystem::new_with_prefix(folder);
        let inner = opened.map_err(|error| WorldError::store(folder, &error))?;
        Self::of(Arc::new(inner), Path::default(), folder)
    }

    #[cfg(not(feature = "cloud"))]
    fn open_address(address: &str) -> Result<Self, WorldError> {
        Err(WorldError::Address {
            place: redacted(address),
            reason: "this program was built without stores behind the network: build it with the feature `cloud` of argil-cli, argil-studio or argil-world".to_owned(),
        })
    }

    #[cfg(feature = "cloud")]
    fn open_address(address: &str) -> Result<Self, WorldError> {
        let refuse = |reason: String| WorldError::Address {
            place: redacted(address),
            reason: redacted(&reason),
        };
        let parsed = url::Url::parse(address).map_err(|error| refuse(error.to_string()))?;
        let variables = settings(std::env::vars_os());
        // Whoever writes http:// wants it.
        let plain =
            (parsed.scheme() == "http").then(|| ("allow_http".to_owned(), "true".to_owned()));
        let opened = object_store::parse_url_opts(&parsed, variables.chain(plain));
        let (inner, prefix) = opened.map_err(|error| refuse(error.to_string()))?;
        let opened = Self::of(inner.into(), prefix, address)?;
        Ok(Self {
            tries: NETWORK_TRIES,
            ..opened
        })
    }

    /// Creates a store over any other one, as for tests.
    ///
    /// # Errors
    /// If no threads can be started.
    pub fn of(inner: Arc<dyn ObjectStore>, prefix: Path, place: &str) -> Result<Self, WorldError> {
        let runtime = Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build();
        let runtime = runtime.map_err(|error| WorldError::store(place, &error))?;
        Ok(Self {
            inner,
            prefix,
            place: redacted(place),
            tries: TRIES,
            timeout: TIMEOUT,
            runtime: Arc::new(Threads {
                handle: runtime.handle().clone(),
                runtime: Some(runtime),
            }),
        })
    }

    /// Returns the address, without secrets.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// Returns the store of a folder in this one.
    pub fn within(&self, folder: &str) -> Self {
        let prefix = folder
            .split('/')
            .filter(|part| !part.is_empty())
            .fold(self.prefix.clone(), |all, part| all.join(part));
        Self {
            prefix,
            place: format!("{}/{folder}", self.place.trim_end_matches('/')),
            ..self.clone()
        }
    }

    /// Returns the store with another time that a request may take. What takes longer has failed, and is tried again.
    pub fn with_timeout(self, timeout: Duration) -> Self {
        Self { timeout, ..self }
    }

    pub(crate) fn runtime(&self) -> &Handle {
        &self.runtime.handle
    }

    /// Tries again what failed or took too long, with longer and longer pauses, unless it cannot succeed.
    async fn again<T, F: Future<Output = Result<T, Error>>>(
        &self,
        once: impl Fn() -> F,
    ) -> Result<T, Error> {
        let (mut pause, mut tries) = (FIRST_PAUSE, 1);
        loop {
            let done = match tokio::time::timeout(self.timeout, once()).await {
                Ok(done) => done,
                Err(late) => Err(Error::Generic {
                    store: "store",
                    source: format!("no answer within {:?}: {late}", self.timeout).into(),
                }),
            };
            match done {
                Err(error) if tries < self.tries && may_pass(&error) => {
                    tokio::time::sleep(pause).await;
                }
                done => return done,
            }
            (pause, tries) = (2 * pause, tries + 1);
        }
    }

    fn path(&self, name: &str) -> Path {
        name.split('/')
            .fold(self.prefix.clone(), |all, part| all.join(part))
    }

    fn error(&self, name: &str, error: &Error) -> WorldError {
        WorldError::store(
            format!("{}/{name}", self.place.trim_end_matches('/')),
            error,
        )
    }

    /// Returns an object of at most some bytes, or `None` if there is none.
    ///
    /// # Errors
    /// If the store fails again and again, or the object is longer.
    pub async fn get(&self, name: &str, max_bytes: u64) -> Result<Option<Bytes>, WorldError> {
        let path = self.path(name);
        let once = || async {
            match self.inner.get(&path).await {
                Ok(found) => body(found, max_bytes).await.map(Some),
                Err(Error::NotFound { .. }) => Ok(None),
                Err(error) => Err(error),
            }
        };
        self.again(once)
            .await
            .map_err(|error| self.error(name, &error))
    }

    /// Returns an object of at most some bytes, or `None` if there is none, or none that may be seen: a store that does not allow
    /// lists says so of all that it does not have.
    ///
    /// # Errors
    /// If the store fails again and again, or the object is longer.
    pub async fn find(&self, name: &str, max_bytes: u64) -> Result<Option<Bytes>, WorldError> {
        let path = self.path(name);
        let once = || async {
            match self.inner.get(&path).await {
                Ok(found) => body(found, max_bytes).await.map(Some),
                Err(
                    Error::NotFound { .. }
                    | Error::PermissionDenied { .. }
                    | Error::Unauthenticated { .. },
                ) => Ok(None),
                Err(error) => Err(error),
            }
        };
        self.again(once)
            .await
            .map_err(|error| self.error(name, &error))
    }

    /// Returns a part of an object and where it begins, or `None` if there is no object. From stores that cannot give parts,
    /// it is the whole object, of at most some bytes. What is behind the object's end is left out.
    ///
    /// # Errors
    /// If the store fails again and again, or the object is longer.
    pub async fn get_part(
        &self,
        name: &str,
        range: Range<u64>,
        max_bytes: u64,
    ) -> Result<Option<(u64, Bytes)>, WorldError> {
        let path = self.path(name);
        let once = || async {
            let options = GetOptions::new().with_range(Some(range.clone()));
            match self.inner.get_opts(&path, options).await {
                Ok(found) => {
                    let begin = found.range.start;
                    let max_bytes = match begin == range.start {
                        true => range.end - range.start,
                        false => max_bytes,
                    };
                    Ok(Some((begin, body(found, max_bytes).await?)))
                }
                Err(Error::NotFound { .. }) => Ok(None),
                Err(error) => Err(error),
            }
        };
        match self.again(once).await {
            Err(error) if !gives_parts(&error) => {
                let whole = self.get(name, max_bytes).await?;
                Ok(whole.map(|bytes| (0, bytes)))
            }
            found => found.map_err(|error| self.error(name, &error)),
        }
    }

    /// Writes an object if there is none yet. Returns whether it was written.
    ///
    /// # Errors
    /// If the store fails again and again.
    pub async fn put_new(&self, name: &str, bytes: Bytes) -> Result<bool, WorldError> {
        let path = self.path(name);
        let once = || async {
            let options = PutOptions::from(PutMode::Create);
            let payload = PutPayload::from_bytes(bytes.clone());
            match self.inner.put_opts(&path, payload, options).await {
                Ok(_) => Ok(true),
                Err(Error::AlreadyExists { .. }) => Ok(false),
                Err(error) => Err(error),
            }
        };
        self.again(once)
            .await
            .map_err(|error| self.error(name, &error))
    }

    /// Removes an object.
    ///
    /// # Errors
    /// If the store fails again and again.
    pub async fn remove(&self, name: &str) -> Result<(), WorldError> {
        let path = self.path(name);
        let once = || async {
            match self.inner.delete(&path).await {
                Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
                Err(error) => Err(error),
            }
        };
        self.again(once)
            .await
            .map_err(|error| self.error(name, &error))
    }

    /// Returns the names and sizes of all objects in a folder.
    ///
    /// # Errors
    /// If the store fails again and again, or cannot list, as a web server.
    pub async fn list(&self, folder: &str) -> Result<Vec<(String, u64)>, WorldError> {
        let prefix = self.path(folder);
        let once = || async {
            let all: Vec<_> = self.inner.list(Some(&prefix)).try_collect().await?;
            let named = all.into_iter().map(|meta| {
                let parts = meta.location.prefix_match(&prefix);
                let parts: Vec<String> = parts
                    .map(|parts| parts.map(|part| part.as_ref().to_owned()).collect())
                    .unwrap_or_default();
                (parts.join("/"), meta.size)
            });
            Ok(named.collect())
        };
        self.again(once)
            .await
            .map_err(|error| self.error(folder, &error))
    }
}

/// The threads that wait for a store. The last owner can be one of their tasks, which may not wait for their end.
#[derive(Debug)]
struct Threads {
    handle: Handle,
    runtime: Option<Runtime>,
}

impl Drop for Threads {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

/// Returns the folder that an address names, if it is not behind the network.
fn folder_of(address: &str) -> Option<&str> {
    match address.strip_prefix("file://") {
        Some(folder) => Some(folder),
        None => (!address.contains("://")).then_some(address),
    }
}
