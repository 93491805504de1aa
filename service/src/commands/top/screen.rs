//! Where views are drawn: in place on a terminal, one below the other elsewhere.

use std::io::{IsTerminal as _, Read as _, Write as _};
use std::sync::Arc;
use std::thread;

use crossterm::{cursor, execute, queue, terminal};
use tokio::sync::Notify;

use super::view::View;

/// Width of a view where there is no terminal.
pub const COLUMNS: usize = 100;
/// Keys that end it: `q`, and Ctrl-C, which a raw terminal hands over as a byte.
const END: [u8; 3] = [b'q', b'Q', 0x03];

/// A terminal is given back as it was when this is dropped.
pub struct Screen {
    is_terminal: bool,
    quit: Arc<Notify>,
}

impl Screen {
    /// Takes the terminal, if there is one on both sides.
    pub fn open() -> anyhow::Result<Self> {
        let is_terminal = std::io::stdout().is_terminal() && std::io::stdin().is_terminal();
        let screen = Self { is_terminal, quit: Arc::new(Notify::new()) };
        if is_terminal {
            terminal::enable_raw_mode()?;
            execute!(std::io::stdout(), terminal::EnterAlternateScreen, cursor::Hide)?;
            let quit = Arc::clone(&screen.quit);
            // Ends with the process: a read of the terminal cannot be called off.
            thread::Builder::new().name("keys".into()).spawn(move || {
                let mut key = [0];
                while let Ok(1) = std::io::stdin().read(&mut key) {
                    if END.contains(&key[0]) {
                        quit.notify_one();
                    }
                }
            })?;
        }
        Ok(screen)
    }

    /// Shows a view instead of the one before.
    pub fn draw(&mut self, view: &View) -> anyhow::Result<()> {
        let mut out = std::io::stdout().lock();
        if !self.is_terminal {
            writeln!(out, "{}", view.text(COLUMNS))?;
            return Ok(out.flush()?);
        }
        let (columns, rows) = terminal::size()?;
        queue!(out, terminal::BeginSynchronizedUpdate)?;
        for (row, line) in (0..rows).zip(view.lines(columns.into())) {
            let shown: String = line.chars().take(columns.into()).collect();
            queue!(out, cursor::MoveTo(0, row), terminal::Clear(terminal::ClearType::UntilNewLine))?;
            write!(out, "{shown}")?;
        }
        queue!(out, terminal::Clear(terminal::ClearType::FromCursorDown), terminal::EndSynchronizedUpdate)?;
        Ok(out.flush()?)
    }

    /// Resolves when a key has been pressed that ends it.
    pub async fn quit(&self) {
        self.quit.notified().await;
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        if self.is_terminal {
            // Nothing more can be done for a terminal that is gone.
            drop(execute!(std::io::stdout(), cursor::Show, terminal::LeaveAlternateScreen));
            drop(terminal::disable_raw_mode());
        }
    }
}
