import pytest

# Whole vehicles and campuses: begun first, so that no process is left with one of them when the rest is done.
LONGEST = (
    "tests/scenarios/test_rides",
    "tests/scenarios",
    "tests/campusloop/test_kilometres",
    "tests/benchmarks",
    "tests/vehicle_agent/stacks",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    def place(item: pytest.Item) -> int:
        return next((k for k, path in enumerate(LONGEST) if item.nodeid.startswith(path)), len(LONGEST))

    items.sort(key=place)
