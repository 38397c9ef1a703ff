"""Variables that name a running server and the token for it. They are no settings of the server itself."""

SERVER_VARIABLE = "CAMPUSLOOP_SERVER"
TOKEN_VARIABLE = "CAMPUSLOOP_TOKEN"
