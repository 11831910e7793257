# What other programs of an X display do to a window: its close button, files that are dropped onto it.
# ICCCM 4.2.8.1 (WM_DELETE_WINDOW), and the XDND protocol, version 5, by Xlib.
import ctypes
import ctypes.util
import time
import urllib.parse

CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31
XDND_VERSION = 5
PATIENCE_S = 10.0


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong), ("format", ctypes.c_int), ("data", ctypes.c_long * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("owner", ctypes.c_ulong), ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong),
                ("property", ctypes.c_ulong), ("time", ctypes.c_ulong)]


class SelectionNotify(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong), ("property", ctypes.c_ulong),
                ("time", ctypes.c_ulong)]


class Event(ctypes.Union):
    _fields_ = [("type", ctypes.c_int), ("message", ClientMessage), ("request", SelectionRequest), ("notify", SelectionNotify),
                ("padding", ctypes.c_long * 24)]


class Connection:
    def __init__(self, display_name):
        xlib = ctypes.CDLL(ctypes.util.find_library("X11"))
        pointer, number, text, integer = ctypes.c_void_p, ctypes.c_ulong, ctypes.c_char_p, ctypes.c_int
        for name, result, arguments in (
                ("XOpenDisplay", pointer, [text]), ("XCloseDisplay", integer, [pointer]), ("XFlush", integer, [pointer]),
                ("XInternAtom", number, [pointer, text, integer]), ("XDefaultRootWindow", number, [pointer]),
                ("XSendEvent", integer, [pointer, number, integer, ctypes.c_long, ctypes.POINTER(Event)]),
                ("XCreateSimpleWindow", number, [pointer, number, integer, integer, ctypes.c_uint, ctypes.c_uint, ctypes.c_uint, number, number]),
                ("XSetSelectionOwner", integer, [pointer, number, number, number]), ("XPending", integer, [pointer]),
                ("XNextEvent", integer, [pointer, ctypes.POINTER(Event)]),
                ("XChangeProperty", integer, [pointer, number, number, number, integer, integer, text, integer])):
            function = getattr(xlib, name)
            function.restype, function.argtypes = result, arguments
        self.xlib = xlib
        self.display = xlib.XOpenDisplay(display_name.encode())
        if not self.display:
            raise OSError(f"no display {display_name}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.xlib.XCloseDisplay(self.display)

    def atom(self, name):
        return self.xlib.XInternAtom(self.display, name.encode(), 0)

    def send(self, window, event):
        self.xlib.XSendEvent(self.display, window, 0, 0, ctypes.byref(event))
        self.xlib.XFlush(self.display)

    def send_message(self, window, kind, *data):
        event = Event(message=ClientMessage(type=CLIENT_MESSAGE, window=window, format=32, message_type=self.atom(kind)))
        for i, value in enumerate(data):
            event.message.data[i] = value
        self.send(window, event)

    def window_of_its_own(self):
        return self.xlib.XCreateSimpleWindow(self.display, self.xlib.XDefaultRootWindow(self.display), 0, 0, 1, 1, 0, 0, 0)

    def events(self, what):
        """Until one comes after which the caller looks for no more."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            if not self.xlib.XPending(self.display):
                time.sleep(0.005)
                continue
            event = Event()
            self.xlib.XNextEvent(self.display, ctypes.byref(event))
            yield event
        raise TimeoutError(f"{what} did not come within {PATIENCE_S:.0f} s")

    def wait_for_message(self, kind):
        for event in self.events(kind):
            if event.type == CLIENT_MESSAGE and event.message.message_type == self.atom(kind):
                return event.message.data

    def answer(self, request, data):
        self.xlib.XChangeProperty(self.display, request.requestor, request.property, request.target, 8, 0, data, len(data))
        self.send(request.requestor, Event(notify=SelectionNotify(
            type=SELECTION_NOTIFY, requestor=request.requestor, selection=request.selection, target=request.target, property=request.property,
            time=request.time)))


def press_close_button(display_name, window):
    with Connection(display_name) as connection:
        connection.send_message(int(window), "WM_PROTOCOLS", connection.atom("WM_DELETE_WINDOW"))


def drop_files(display_name, window, place, paths):
    """Drags files there (pixels of the screen) and lets them go. Returns False where the window does not want them."""
    target = int(window)
    with Connection(display_name) as connection:
        source, selection, kind = connection.window_of_its_own(), connection.atom("XdndSelection"), connection.atom("text/uri-list")
        connection.xlib.XSetSelectionOwner(connection.display, selection, source, 0)
        connection.send_message(target, "XdndEnter", source, XDND_VERSION << 24, kind)
        connection.send_message(target, "XdndPosition", source, 0, place[0] << 16 | place[1], 0, connection.atom("XdndActionCopy"))
        if not connection.wait_for_message("XdndStatus")[1] & 1:
            connection.send_message(target, "XdndLeave", source)
            return False
        connection.send_message(target, "XdndDrop", source, 0, 0)
        uris = "".join(f"file://{urllib.parse.quote(path)}\r\n" for path in paths).encode()
        for event in connection.events("a request for what is dropped"):
            if event.type == SELECTION_REQUEST:
                connection.answer(event.request, uris)
                break
        return connection.wait_for_message("XdndFinished")[1] != 0  # GLFW says there how many bytes it took
