//! `sturz top`: a running daemon, seen anew each second. It listens to `report`, which costs the physics nothing that others
//! who listen do not, and asks `info` for the rest.

mod screen;
mod view;

use std::sync::Arc;
use std::time::Duration;

use anyhow::anyhow;
use prost::Message as _;
use sturz_protocol::keys::Keys;
use sturz_protocol::v1;
use tokio::sync::{Notify, watch};
use tokio::time::{Instant, MissedTickBehavior, interval};
use zenoh::Session;
use zenoh::sample::{Sample, SampleKind};

use crate::cli;
use crate::commands::{Failure, Place, ask, connect, runtime};
use crate::daemon::asked_to_end;
use screen::Screen;
use view::View;

/// More often than this nobody can read, and `info` costs the physics a hash of the state each time.
const SHORTEST: f64 = 0.1;

/// Shows a daemon until `q`, Ctrl-C, SIGTERM or its end.
pub fn top(options: &cli::Top) -> Result<(), Failure> {
    let every = Some(options.every).filter(|&every| every >= SHORTEST).map(Duration::try_from_secs_f64);
    let Some(Ok(every)) = every else {
        let text = format!("--every is {}, must be finite and at least {SHORTEST} s", options.every);
        return Err(Failure::Usage(text));
    };
    runtime()?.block_on(async {
        let at = Place { endpoint: &options.endpoint, config: options.config.as_deref(), tls: options.tls.as_deref() };
        let (session, keys) = connect(options.name.as_deref(), at).await?;
        let info = v1::Info::decode(ask(&session, keys.info()).await?.as_slice());
        let report = v1::Report::decode(ask(&session, keys.report_latest()).await?.as_slice());
        let (info, report) = (info.map_err(anyhow::Error::from)?, report.map_err(anyhow::Error::from)?);
        let first = View { info, report, trouble: None };
        if options.once {
            print!("{}", first.text(screen::COLUMNS));
        } else {
            follow(&session, &keys, first, every).await?;
        }
        session.close().await.map_err(|error| anyhow!(error))?;
        Ok(())
    })
}

/// Draws until somebody has had enough, or the daemon is gone.
async fn follow(session: &Session, keys: &Keys, mut view: View, every: Duration) -> Result<(), Failure> {
    let (newest, mut reports) = watch::channel(view.report.clone());
    let hear = move |sample: Sample| {
        if let Ok(report) = v1::Report::decode(sample.payload().to_bytes().as_ref()) {
            newest.send_replace(report);
        }
    };
    let subscribed = session.declare_subscriber(keys.report()).callback(hear).await;
    let _reports = subscribed.map_err(|error| anyhow!(error))?;
    let gone = Arc::new(Notify::new());
    let note = Arc::clone(&gone);
    let watch = move |sample: Sample| {
        if sample.kind() == SampleKind::Delete {
            note.notify_one();
        }
    };
    let watched = session.liveliness().declare_subscriber(keys.alive()).callback(watch).await;
    let _alive = watched.map_err(|error| anyhow!(error))?;

    let end = asked_to_end(false)?;
    tokio::pin!(end);
    let mut screen = Screen::open()?;
    let mut ticks = interval(every);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut heard = Instant::now();
    loop {
        screen.draw(&view)?;
        tokio::select! {
            () = &mut end => return Ok(()),
            () = screen.quit() => return Ok(()),
            () = gone.notified() => {
                drop(screen);
                println!("{} has ended", view.info.instance);
                return Ok(());
            }
            _ = ticks.tick() => {}
        }
        if reports.has_changed().unwrap_or(false) {
            heard = Instant::now();
            view.report = reports.borrow_and_update().clone();
        }
        look(session, keys, &mut view, heard.elapsed()).await;
    }
}

/// Asks for `info`, and says so where nothing comes.
async fn look(session: &Session, keys: &Keys, view: &mut View, silence: Duration) {
    match ask(session, keys.info()).await {
        Ok(bytes) => {
            view.info = v1::Info::decode(bytes.as_slice()).unwrap_or_else(|_| view.info.clone());
            // A paused run reports nothing new; one that steps does.
            let is_late = view.info.state() == v1::RunState::Running && silence > Duration::from_secs(10);
            view.trouble = is_late.then(|| format!("no report for {} s", silence.as_secs()));
        }
        Err(failure) => view.trouble = Some(failure.to_string()),
    }
}
