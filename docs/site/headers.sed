# What Doxygen reads of a header: its names without the namespace that all share, so that each header lists its own.
/namespace copepod/s/.*//
s|^#pragma once|/** @file */|
/operator==.*= default;/s/.*//
s|^inline constexpr auto \w+_names|/** Words in files and messages, in the order of their values. */ &|
# Equations, indented by three spaces, have lines of their own.
s|^( *///)   ([^ ].*)|\1 <br>\2|
# What its name and its class explain.
s|^  (explicit )?\w*(Error\|Refused\|Lost\|Passed\|Interrupted\|Failed)\(|/** The reason reads "problem (why). What to do." */ &|
s|^  void resize\(|/** Makes room for so many bodies; the values are not set. */ &|
