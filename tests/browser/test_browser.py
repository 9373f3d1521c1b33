"""The browser of these tests can do what the pages need."""


def test_webgl_works_here(page):
    page.set_content("<canvas></canvas>")
    assert page.evaluate("document.querySelector('canvas').getContext('webgl2') !== null")
