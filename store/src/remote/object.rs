//! One object, of one version.

use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use object_store::path::Path;
use object_store::{GetOptions, GetRange, GetResult, ObjectMeta, ObjectStore};
use tokio::runtime::{Builder, Runtime};

use super::fetch::Fetch;
use super::{client, fault};
use crate::options::Options;
use crate::traffic::Traffic;
use crate::unavailable::Unavailable;

/// An object whose bytes are fetched by range. Every answer is held against the version of the first.
#[derive(Debug)]
pub(super) struct Object {
    /// Drives the connections; callers of any thread wait in it for their answers.
    runtime: Runtime,
    store: Arc<dyn ObjectStore>,
    path: Path,
    /// What the first answer said.
    meta: ObjectMeta,
    traffic: Arc<Traffic>,
    /// How often a part is asked for again whose bytes did not come whole.
    retries: usize,
}

/// Why there are no bytes.
enum Failure {
    /// Another answer would be the same, or the library has asked often enough.
    Final(io::Error),
    /// The answer ended early. The library asks for the rest itself, but only of servers that name versions by tags.
    CutShort(io::Error),
}

impl Object {
    /// Asks for the last `end_len` bytes, or all of a shorter object; gives them too.
    pub(super) fn open(url: &str, end_len: u64, options: &Options) -> io::Result<(Self, Vec<u8>)> {
        let (store, path) = client::of(url, options.retries)?;
        let runtime = Builder::new_multi_thread().worker_threads(1).thread_name("objects").enable_all().build()?;
        let (meta, end) = again(options.retries, || {
            runtime.block_on(async {
                let answer = get(&*store, &path, GetRange::Suffix(end_len)).await?;
                let (meta, range) = (answer.meta.clone(), answer.range.clone());
                Ok((meta, body(answer, range).await?))
            })
        })?;
        let traffic = Arc::clone(&options.traffic);
        traffic.count_request(end.len() as u64);
        Ok((Self { runtime, store, path, meta, traffic, retries: options.retries }, end))
    }

    /// Length in bytes.
    pub(super) fn size(&self) -> u64 {
        self.meta.size
    }

    /// What names this version of the object, if the server says anything that does.
    pub(super) fn version(&self) -> Option<String> {
        let dated = self.meta.last_modified.timestamp() != 0;
        let date = || dated.then(|| self.meta.last_modified.to_rfc3339());
        let tag = self.meta.e_tag.clone().or_else(date)?;
        Some(format!("{tag} {}", self.meta.size))
    }
}

impl Fetch for Object {
    fn fetch(&self, range: Range<u64>) -> io::Result<Vec<u8>> {
        let once = async || {
            let answer = get(&*self.store, &self.path, GetRange::Bounded(range.clone())).await?;
            let ObjectMeta { size, e_tag, last_modified, .. } = &answer.meta;
            if (size, e_tag, last_modified) != (&self.meta.size, &self.meta.e_tag, &self.meta.last_modified) {
                let replaced = "the object was replaced while it was read; start again";
                return Err(Failure::Final(Unavailable::error(replaced)));
            }
            body(answer, range.clone()).await
        };
        let bytes = again(self.retries, || self.runtime.block_on(once()))?;
        self.traffic.count_request(bytes.len() as u64);
        Ok(bytes)
    }
}

/// Asks, and asks again for what was cut short: at once, then with waits that grow to some seconds.
fn again<T>(retries: usize, ask: impl Fn() -> Result<T, Failure>) -> io::Result<T> {
    let mut retry = 0;
    loop {
        match ask() {
            Ok(found) => return Ok(found),
            Err(Failure::CutShort(_)) if retry < retries => {
                std::thread::sleep(Duration::from_millis(if retry == 0 { 0 } else { 100 << retry.min(5) }));
                retry += 1;
            }
            Err(Failure::Final(error) | Failure::CutShort(error)) => return Err(error),
        }
    }
}

async fn get(store: &dyn ObjectStore, path: &Path, range: GetRange) -> Result<GetResult, Failure> {
    let options = GetOptions::new().with_range(Some(range));
    store.get_opts(path, options).await.map_err(|error| Failure::Final(fault::explain(&error)))
}

/// The bytes of an answer, as many as were asked for.
async fn body(answer: GetResult, range: Range<u64>) -> Result<Vec<u8>, Failure> {
    let bytes = answer.bytes().await.map_err(|error| Failure::CutShort(fault::explain(&error)))?;
    if bytes.len() as u64 != range.end - range.start {
        return Err(Failure::CutShort(Unavailable::error("the answer was cut short")));
    }
    Ok(bytes.into())
}
