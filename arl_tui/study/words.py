"""Every word of the study's own pages that a participant reads. The study's texts come from its own files."""

GO_ON = "Press [reverse] Enter [/] to go on"
READ_ON = "Press [reverse] Enter [/] to read on"
STOP = "[reverse] Q [/] to stop"
CONSENT = "Your consent"
CONSENT_HELP = (
    "Answer every statement: [reverse] Y [/] yes, [reverse] N [/] no, arrow keys to move. Then press "
    "[reverse] Enter [/]."
)
CONSENT_NEEDED = "You can take part only if you agree to the statements marked with *."
CONSENT_OPEN = "Please answer every statement."
DECLINE_HEADING = "You do not want to take part"
DECLINE = (
    "That is fine. Nothing about you is kept.\n\nPress [reverse] Enter [/] to leave, [reverse] B [/] to go "
    "back."
)
STOP_HEADING = "Stop here?"
STOP_TEXT = (
    "You can stop at any time, without giving a reason. What you have done so far is kept. If you want it to "
    "be deleted, "
    "tell the experimenter your code: [b]{code}[/].\n\nPress [reverse] Y [/] to stop, [reverse] N [/] to go "
    "on."
)
STOPPED = "You have stopped. Thank you. Please tell the experimenter. Your code is [b]{code}[/]."
BREAK_HEADING = "Time for a break"
BREAK_TEXT = "Look away from the screen, and stretch. Go on when you are ready."
BREAK_WAIT = "You can go on in {seconds} s"
BREAK_OVER = "The break is over: please go on when you are ready.\n" + GO_ON
ANSWER_LIKERT = "Press a number or use the arrow keys, then [reverse] Enter [/]"
ANSWER_SCALE = "Move the mark with the arrow keys, then press [reverse] Enter [/]"
ANSWER_CHOICE = "Press a number or use the arrow keys, then [reverse] Enter [/]"
ANSWER_SEVERAL = "Choose with [reverse] Space [/] as many as apply, then press [reverse] Enter [/]"
ANSWER_PRESS = "Do what the sentence says"
ANSWER_TYPED = "Type your answer, then press [reverse] Enter [/]"
MAY_SKIP = "You may leave this out: press [reverse] Ctrl+N [/]"
PROGRESS = "Question {number} of {count}"
BLOCK = "Block {number} of {count}"
PART = "Part {number} of {count}"
THANKS = "Thank you!"
NUMBERS = "You watched [b]{games}[/] games and pressed [b]{presses}[/] keys that counted."
TAKEN_BACK = "You took [b]{presses}[/] presses back."
HOW_IT_PLAYED = "{unit} per game at the beginning: [b]{first}[/]. At the end: [b]{last}[/]."
HOW_IT_PLAYED_IN_BLOCK = (
    "Block {number}: {unit} per game at the beginning [b]{first}[/], at the end [b]{last}[/]."
)
ORDER = "The conditions of your session were, in this order: {order}."
CODE = "Your code is [b]{code}[/]. Keep it if you may want your data to be deleted later."
LEAVE = "Press [reverse] Enter [/] to leave"
