# Two commands: `make test` passes all tests.
.PHONY: test lint bench validate
test:
	cargo test --release -p sturz-engine -p sturz-protocol -p sturz-tests
lint:
	cargo fmt --all --check
	cargo clippy --release -p sturz-engine -p sturz-protocol -p sturz-tests --all-targets -- -D warnings
bench:
	cargo run --release -p sturz-tests --bin bench -- all
validate:
	cargo run --release -p sturz-tests --bin validate
