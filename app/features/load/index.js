// Points are collected from the beginning, also before the page is opened.

import { connectSlips } from "./slips.js"

export const connect = connectSlips
