"""`editor`: support for decks in text editors: colours and snippets for editors that read TextMate grammars, a language server for others.

Everything is made from the program's own table of keywords (`qsmpm help --json`), so no keyword is hard-coded here.
"""
