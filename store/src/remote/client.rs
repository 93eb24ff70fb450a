//! The client of each kind of object store.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use object_store::aws::AmazonS3Builder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{BackoffConfig, ClientOptions, ObjectStore, RetryConfig};
use url::Url;

use super::fault;

/// The store that a URL points into, and the object's path in it. Credentials and endpoint come from the environment,
/// under the names that the provider's tools use.
pub(super) fn of(url: &str, retries: usize) -> io::Result<(Arc<dyn ObjectStore>, Path)> {
    let wrong = |detail: &str| io::Error::new(io::ErrorKind::InvalidInput, detail.to_string());
    let parsed = Url::parse(url).map_err(|e| wrong(&format!("this is no URL: {e}")))?;
    let host =
        parsed.host_str().filter(|host| !host.is_empty()).ok_or_else(|| wrong("a URL needs a host or a bucket"))?;
    let path = Path::from_url_path(parsed.path()).map_err(|e| wrong(&e.to_string()))?;
    if path.as_ref().is_empty() {
        return Err(wrong("the URL names no object: give s3://bucket/path/name.rtrace"));
    }
    choose_cryptography();
    let store: object_store::Result<Arc<dyn ObjectStore>> = match parsed.scheme() {
        "s3" | "s3a" => {
            let builder = AmazonS3Builder::from_env().with_bucket_name(host).with_retry(retry(retries));
            builder.build().map(|store| Arc::new(store) as _)
        }
        "gs" => {
            let builder = GoogleCloudStorageBuilder::from_env().with_bucket_name(host).with_retry(retry(retries));
            builder.build().map(|store| Arc::new(store) as _)
        }
        "http" | "https" => {
            let mut base = parsed.clone();
            base.set_path("/");
            base.set_fragment(None);
            // Who writes http:// asks for a connection that is not encrypted.
            let client = ClientOptions::new().with_allow_http(parsed.scheme() == "http");
            let builder = HttpBuilder::new().with_url(base).with_client_options(client).with_retry(retry(retries));
            builder.build().map(|store| Arc::new(store) as _)
        }
        scheme => return Err(wrong(&format!("{scheme}:// is not known; s3://, gs://, http:// and https:// are"))),
    };
    Ok((store.map_err(|error| fault::explain(&error))?, path))
}

/// Gives up after some seconds: a server that is not there is more often a wrong name than a passing fault.
fn retry(max_retries: usize) -> RetryConfig {
    let backoff = BackoffConfig { max_backoff: Duration::from_secs(5), ..BackoffConfig::default() };
    RetryConfig { backoff, max_retries, retry_timeout: Duration::from_secs(60) }
}

/// Connections by TLS need a provider of cryptography, chosen once in a process.
fn choose_cryptography() {
    // If there is one already, it serves as well.
    let _ = rustls::crypto::ring::default_provider().install_default();
}
