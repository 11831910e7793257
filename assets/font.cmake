# Sets WARPSCOPE_FONT_FILE: DejaVuSans.ttf, the font of the panels and of the captions in montages.
find_file(WARPSCOPE_FONT_FILE DejaVuSans.ttf
  PATHS /usr/share/fonts /usr/local/share/fonts
  PATH_SUFFIXES truetype/dejavu dejavu dejavu-sans-fonts TTF truetype
  NO_CMAKE_FIND_ROOT_PATH
  DOC "DejaVuSans.ttf")
if(NOT WARPSCOPE_FONT_FILE)
  message(FATAL_ERROR "The font DejaVuSans.ttf was not found. Install it (Debian: fonts-dejavu-core) or set WARPSCOPE_FONT_FILE to its path.")
endif()
