"""Print: the page on paper, in light colours, with its pictures as they are on screen."""

PAGE = True
