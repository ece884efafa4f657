"""A page for other computers asks for its token."""

from checks import check
from on_page.tab import Floor, Tab


def by_token(browser, folder):
    """A page for other computers: nothing before the token, everything after it, also when the page is opened again."""
    token = "a-token-of-a-test-0123456789"
    with Floor(folder, token=token) as floor:
        check("the page is encrypted", floor.address.startswith("https://"), floor.address)
        tab = Tab(browser, floor.address, 390, 844)
        tab.view("measure")
        tab.page.wait_for_selector("#token")
        check("nothing is shown before the token", "probe-1" not in tab.text("body"), tab.text("h1"))
        tab.picture("login-390")
        tab.accessible("the login")
        tab.page.keyboard.type("guess")
        tab.page.keyboard.press("Enter")
        tab.until("document.getElementById('notice').innerText.includes('not the token')")
        tab.page.fill("#token", token)
        tab.page.keyboard.press("Enter")
        tab.until("document.querySelectorAll('[role=meter]').length === 3")
        tab.accessible("live values")
        tab.page.reload()
        tab.until("document.querySelectorAll('[role=meter]').length === 3")
        check("the browser keeps that it was let in", tab.page.evaluate("document.cookie") == "", "and no script reads the cookie")
        tab.errors = [error for error in tab.errors if "401" not in error]
        tab.close()
