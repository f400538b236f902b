// How others reach this page.

import { declared } from "./store.js"

// Whether the address of this page is that of the computer for itself; app/server_log.py has the same names
const opensHereOnly = () => ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname)
// Whether others can open links of this page: the server may have another name for them
export const opensElsewhere = () => !opensHereOnly() || declared.reach.origins.length > 0

export const originForOthers = () => (opensHereOnly() && declared.reach.origins[0]) || location.origin
