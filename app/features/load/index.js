// Points are collected from the beginning, also before the page is opened.

export { connectSlips as connect } from "./slips.js"
