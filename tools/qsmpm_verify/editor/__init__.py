"""`editor`: decks in an editor: colours and snippets for anything that reads TextMate grammars, a language server for the rest.

Everything is made from the program's own table of keywords (`qsmpm help --json`), so that nothing here knows a card by name.
"""
