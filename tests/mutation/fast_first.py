"""A pytest plug-in: property tests last, since most mutants fall to a test by hand."""


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: hasattr(getattr(item, "obj", None), "hypothesis"))
